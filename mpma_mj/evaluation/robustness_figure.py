"""Figure of p_e under disturbances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.evaluation.disturbances import DISTURBANCES, Disturbance, Level
from mpma_mj.evaluation.robustness import RECOVERED, Robustness, Tally
from mpma_mj.utils.text import printable
from mpma_mj.visualization.colours import module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

__all__ = ["write_figures"]

Array = NDArray[np.float64]
Measure = Callable[[str, str, Level], Tally]

_COLUMNS = 4
_WIDE = ("locked", "unseen")  # panels with many names below
_SPREAD = 0.62  # of the place of a name, over which agents are side by side
_MARKERS = "osD^v<PXph"


def write_figures(path: Path, robustness: Robustness) -> None:
    """Write the figure of p_e without learning and, where there was some, after fine-tuning.

    The second is `NAME_fine_tuned.png`; one that is there is removed where nothing was fine-tuned.

    Args:
        path: The PNG file.
        robustness: The results.
    """
    _write_figure(path, robustness, robustness.agents, robustness.p_e, "p_e, %")
    second = path.with_name(f"{path.stem}_fine_tuned.png")
    second.unlink(missing_ok=True)
    if robustness.fine_tuned:
        label = f"p_e after {robustness.epochs} epochs of fine-tuning, %"
        _write_figure(second, robustness, robustness.fine_tuned, robustness.p_e_after, label)


def _write_figure(
    path: Path, robustness: Robustness, agents: Sequence[str], measure: Measure, label: str
) -> None:
    """Draw a panel for each disturbance, with a line for each agent."""
    places, rows, columns = _places(list(robustness.levels))
    with figure_file(path, 0.9 + 3.0 * columns, 0.9 + 2.6 * rows) as figure:
        grid = figure.add_gridspec(rows, columns)
        axes: list[Axes] = []
        for name, (row, column) in places.items():
            where = grid[row, column : column + _width(name)]
            axes.append(figure.add_subplot(where, sharey=axes[0] if axes else None))
            _draw(axes[-1], robustness, name, agents, measure)
            axes[-1].tick_params(labelleft=column == 0)
        figure.supylabel(label, fontsize="medium")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2 * columns, frameon=False)


def _width(name: str) -> int:
    return 2 if name in _WIDE else 1


def _places(names: Sequence[str]) -> tuple[dict[str, tuple[int, int]], int, int]:
    """Return row and column of each panel, and the numbers of rows and columns."""
    places, row, column, most = dict[str, tuple[int, int]](), 0, 0, 0
    for name in names:
        if column + _width(name) > _COLUMNS:
            row, column = row + 1, 0
        places[name] = row, column
        column += _width(name)
        most = max(most, column)
    return places, row + 1, most


def _draw(
    axis: Axes, robustness: Robustness, name: str, agents: Sequence[str], measure: Measure
) -> None:
    """Draw means over levels with bands for their intervals, or with bars where levels are names.

    A cross at the upper edge shows that some of an agent's runs diverged.
    """
    disturbance, levels = DISTURBANCES[name], robustness.levels[name]
    if disturbance.is_ordered:
        levels = sorted(levels)
    x = np.array(levels if disturbance.is_ordered else range(len(levels)), np.float64)
    colours = module_colours(len(agents))
    for number, (agent, colour) in enumerate(zip(agents, colours, strict=True)):
        tallies = [measure(agent, name, level) for level in levels]
        ends = [(tally.mean.low, tally.mean.mean, tally.mean.high) for tally in tallies]
        low, mean, high = np.array(ends, float).reshape(-1, 3).T
        marker = _MARKERS[number % len(_MARKERS)]
        look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 4}
        look["label"] = printable(agent)
        place = x
        if disturbance.is_ordered:
            axis.plot(x, mean, linewidth=1.5, **look)
            axis.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0)
        else:
            place = x + _SPREAD * ((number + 0.5) / len(agents) - 0.5)
            around = [np.nan_to_num(mean - low), np.nan_to_num(high - mean)]
            axis.errorbar(place, mean, yerr=around, linestyle="none", capsize=2, **look)
        lost = place[[tally.diverged > 0 for tally in tallies]]
        edge = axis.get_xaxis_transform()
        for cross in axis.plot(lost, np.ones(len(lost)), "x", color=colour, transform=edge):
            cross.set(clip_on=False, in_layout=False)
    if disturbance.is_ordered:
        ticks = [float(level) for level in levels]
        axis.set_xticks(ticks, [f"{level:g}" for level in ticks])
        _order(axis, disturbance)
    else:
        axis.set_xticks(range(len(levels)), [_on_lines(level) for level in levels])
        axis.set_xlim(-0.5, len(levels) - 0.5)
        for between in np.arange(0.5, len(levels) - 1):
            axis.axvline(between, color="0.9", linewidth=0.8)
    axis.axhline(RECOVERED, color="0.75", linewidth=0.8, linestyle="--", zorder=1)
    axis.set_yscale("log")
    label_decades(axis.yaxis)
    axis.grid(axis="y", color="0.94")
    axis.set_axisbelow(True)
    axis.set_title(disturbance.title, fontsize="medium", loc="left")
    axis.tick_params(labelsize="small")
    axis.spines[["top", "right"]].set_visible(False)


def _order(axis: Axes, disturbance: Disturbance) -> None:
    """Order the levels from easy to hard."""
    first, *_, last = map(float, disturbance.levels)
    if first > last:
        axis.invert_xaxis()


def _on_lines(level: Level) -> str:
    """Return the name of a level on several lines, for narrow places."""
    return printable(Path(str(level)).stem).replace("_", "\n").replace("-", "\n")
