"""Growth as a picture: where runs settle, beside runs of every fixed number of modules."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from mpma_mj.sweep.folder import RunResult
from mpma_mj.sweep.growth import SETTLED, by_number, growing_runs
from mpma_mj.sweep.measures import spread, values
from mpma_mj.visualization.colours import DEMONSTRATED, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["write_figure"]

_GROWN = module_colours(2)[1]
_APART, _SPRAY = 0.15, 0.12  # of the two kinds from their number, and of runs from each other

_PANELS = (("p_e, %", "p_e_percent"), ("prediction error, %", "prediction_error_percent"))


def write_figure(path: Path, runs: Sequence[RunResult], title: str) -> None:
    """Draw p_e and prediction error of every run over its number of modules.

    Args:
        path: The PNG file.
        runs: RunResult runs.
        title: What they imitate.
    """
    with figure_file(path, 9.0, 3.6) as figure:
        for axis, (name, measure) in zip(figure.subplots(1, 2), _PANELS, strict=True):
            _draw(axis, runs, measure)
            axis.set(xlabel="number of modules", ylabel=name)
            axis.spines[["top", "right"]].set_visible(False)
            axis.set_ylim(0.0, 1.05 * axis.dataLim.y1)
        handles, names = axis.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3, fontsize="small")
        figure.suptitle(f"Growth beside fixed numbers of modules ({title})", fontsize="medium")


def _draw(axis: Axes, runs: Sequence[RunResult], measure: str) -> None:
    fixed = by_number(runs)
    for number, of_number in fixed.items():
        found = values(of_number, measure)
        place = number - _APART + _SPRAY * np.linspace(-0.5, 0.5, len(found))
        label = "fixed number, every run" if number == min(fixed) else None
        axis.plot(place, found, "o", color=DEMONSTRATED, markersize=3.5, label=label)
    means = [spread(of_number, measure).mean for of_number in fixed.values()]
    axis.plot(list(fixed), means, color="black", linewidth=1.2, label="fixed number, mean")
    grown = growing_runs(runs)
    settled = np.array(values(grown, SETTLED))
    place = settled + _APART + _SPRAY * np.linspace(-0.5, 0.5, len(settled))
    axis.plot(place, values(grown, measure), "D", color=_GROWN, markersize=5, label="grown")
    axis.set_xticks(list(fixed))
