"""Figure of free-running: directions of segments, and errors over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.analysis.free_running import FreeRun
from mpma_mj.analysis.free_running_measures import HOLDING, nearest_over_time
from mpma_mj.kinematics import SEGMENT_NAMES
from mpma_mj.metrics import error_over_time
from mpma_mj.motions import Motion
from mpma_mj.visualization.colours import DEMONSTRATED, INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = ["drawn_spans", "write_figure"]

Array = NDArray[np.float64]

_COLOURS = ("C3", "C2", "C0")  # of x, y and z, as in trajectory.png
_PALE = 0.3  # opacity of what would be demonstrated
_LONG = 20.0  # s; beyond that only the first and the last repetition are drawn (choice)


def write_figure(path: Path, free: FreeRun, motion: Motion) -> None:
    """Draw all segments' directions, demonstrated and imitated, and the errors over time.

    Args:
        path: The PNG file.
        free: Postures from the release on.
        motion: The motion that had been learned.
    """
    spans = drawn_spans(free)
    with figure_file(path, 9.0, 8.6) as figure:
        axes = figure.subplots(5, len(spans), sharex="col", sharey="row", squeeze=False)
        for column, span in zip(axes.T, spans, strict=True):
            _directions(column[:4], free, span)
            _errors(column[4], free, span)
            column[4].set_xlabel("time since the demonstration was taken away, s", fontsize="small")
            for axis in column:
                _starts(axis, free, span, "a repetition starts" if axis is column[4] else "")
                axis.margins(x=0)
                axis.spines[["top", "right"]].set_visible(False)
        if len(spans) > 1:
            for axis, name in zip(axes[0], ("first repetition", "last repetition"), strict=True):
                axis.set_title(name, fontsize="small")
        for axis, segment in zip(axes[:, 0], SEGMENT_NAMES, strict=False):
            axis.set(ylim=(-1.08, 1.08), ylabel=segment.replace("_", " "))
        axes[4, 0].set_ylabel("error, %")
        axes[4, 0].set_ylim(bottom=0.0)
        handles = [
            handle
            for axis in (axes[0, 0], axes[4, 0])
            for handle in axis.get_legend_handles_labels()[0]
        ]
        columns = -(-len(handles) // 3)  # x, y and z below each other
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, fontsize="small")
        figure.suptitle(f"Free-running with anticipation ({motion.name})", fontsize="medium")


def drawn_spans(free: FreeRun) -> list[slice]:
    """Return which steps are drawn side by side: all, or of many the first and last repetition."""
    steps = len(free.posture)
    if steps <= _LONG * free.rate or steps < 2 * free.period:
        return [slice(0, steps)]
    return [slice(0, free.period), slice(steps - free.period, steps)]


def _directions(axes: Sequence[Axes], free: FreeRun, span: slice) -> None:
    """Draw each segment in its axes."""
    time = np.arange(span.start, span.stop) / free.rate
    looks: tuple[tuple[Array, str, dict[str, Any]], ...] = (
        (free.reference, "would be demonstrated", {"alpha": _PALE, "linewidth": 3.0}),
        (free.posture, "free-running", {"linewidth": 1.2}),
    )
    for number, axis in enumerate(axes):
        for posture, said, look in looks:
            for part, colour in enumerate(_COLOURS):
                line = posture[span, 3 * number + part]
                axis.plot(time, line, color=colour, **look, label=f"{'xyz'[part]} {said}")


def _errors(axis: Axes, free: FreeRun, span: slice) -> None:
    time = np.arange(span.start, span.stop) / free.rate
    error_colour, nearest_colour = module_colours(2)
    errors = error_over_time(free.posture[span], free.reference[span])
    axis.plot(time, errors, color=error_colour, label="error now")
    nearest = nearest_over_time(free, free.posture)[span]
    axis.plot(time, nearest, color=nearest_colour, label="error to the nearest of the label")
    axis.axhline(
        HOLDING, color=INK, linestyle="--", linewidth=0.8, label=f"{HOLDING:g} %: held below"
    )


def _starts(axis: Axes, free: FreeRun, span: slice, label: str) -> None:
    """Mark where the next repetitions start."""
    starts = np.arange(span.start + free.period, span.stop, free.period) / free.rate
    if len(starts):
        look: dict[str, Any] = {"color": DEMONSTRATED, "linewidth": 1.0, "zorder": 0}
        top = axis.get_xaxis_transform()
        axis.vlines(starts, 0, 1, transform=top, label=label, **look)
