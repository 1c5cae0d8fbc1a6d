"""How time and memory of training grow, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from mpma_mj.bench.scaling import AXES, Axis, Scaling
from mpma_mj.visualization.colours import module_colours
from mpma_mj.visualization.figure_file import figure_file, label_decades

__all__ = ["write_figure"]

_TITLES: dict[Axis, str] = {
    "steps": "steps of an epoch",
    "modules": "modules",
    "nodes": "nodes of a reservoir",
    "runs": "runs side by side",
}


def write_figure(path: Path, scaling: Scaling) -> None:
    """Draw a panel for each axis: time of an epoch on the left, peak memory on the right.

    Args:
        path: The PNG file.
        scaling: What was measured.
    """
    with figure_file(path, 10.0, 7.0) as figure:
        for panel, axis in zip(figure.subplots(2, 2).flat, AXES, strict=True):
            _panel(panel, scaling, axis)
        figure.suptitle(
            "What an epoch of training takes; dashed: fitted power laws", fontsize="medium"
        )


def _panel(left: Axes, scaling: Scaling, axis: Axis) -> None:
    points = scaling.along(axis)
    amounts = np.array([one.point.amount for one in points])
    right = left.twinx()
    measures = {
        "time, s": (left, [one.epoch for one in points]),
        "peak memory, MB": (right, [one.memory / 1e6 for one in points]),
    }
    lines = []
    for (name, (side, values)), colour, fitted in zip(
        measures.items(), module_colours(2), scaling.exponents(axis), strict=True
    ):
        label = f"{name.split(',')[0]}, exponent {fitted:.2f}"
        lines += side.plot(amounts, values, "o-", color=colour, markersize=4, label=label)
        half = len(amounts) // 2
        middle = np.exp(np.mean(np.log(values[half:])) - fitted * np.mean(np.log(amounts[half:])))
        side.plot(amounts[half:], middle * amounts[half:] ** fitted, "--", color=colour, lw=1.0)
        side.set_yscale("log")
        label_decades(side.yaxis)
        side.set_ylabel(name, color=colour, fontsize="small")
        side.tick_params(labelsize="small")
        side.spines["top"].set_visible(False)
    left.set_xscale("log")
    left.set_xticks(amounts, [f"{amount:,}" for amount in amounts])
    left.minorticks_off()
    left.set_xlabel(_TITLES[axis], fontsize="small")
    left.legend(handles=lines, fontsize="small", loc="upper left")
