"""Report of free-running: how long and how precisely a motion continues, with a figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.analysis.free_running import FreeRun
from mpma_mj.kinematics import SEGMENT_NAMES
from mpma_mj.metrics import error_over_time
from mpma_mj.motions import Motion
from mpma_mj.utils.text import markdown_table
from mpma_mj.visualization.colours import DEMONSTRATED, INK, module_colours
from mpma_mj.visualization.figure_file import figure_file

__all__ = [
    "HOLDING",
    "WINDOWS",
    "FreeRunMeasures",
    "as_markdown",
    "drawn_spans",
    "measure",
    "nearest_over_time",
    "write_figure",
]

Array = NDArray[np.float64]
Ending = Literal["standstill", "cycle", "wandering"]

HOLDING = 10.0
"""Largest error while the motion is held, percent of a coordinate's range (choice)."""

WINDOWS = (1.0, 2.0, 5.0)
"""Times from the release over which p_e is measured, s."""

_STANDS = 0.1  # amplitude, of the demonstrated one, below which arms stand still (choice)
_REPEATS = 0.5  # change between repetitions, of the amplitude, below which it is a cycle (choice)


@dataclass(frozen=True)
class FreeRunMeasures:
    """Measures; errors in percent of a coordinate's range.

    Attributes:
        held_s: Time until the error first exceeds `HOLDING`, s; all of the time if it never does.
        near_s: The same for the distance to the nearest demonstrated posture of the same label.
        p_e_percent: Error over the first seconds, by their number, and over all of the time.
        still_percent: The same for arms that stay where they are at the release.
        nearest_percent: Mean distance to the nearest demonstrated posture of the same label.
        still_nearest_percent: The same for arms that stay where they are.
        chance_percent: Mean distance of two demonstrated postures, the error of no timing at all.
        speed: Mean speed of the posture over the demonstrated one.
        amplitude: Rms deviation from the mean posture over the demonstrated one, in the last
            repetition.
        change: Rms change from the last repetition but one to the last, over the rms deviation
            from the mean posture in the last.
        ending: "standstill" where the amplitude is below 0.1, "cycle" where repetitions are
            alike, change below 0.5, else "wandering".
    """

    held_s: float
    near_s: float
    p_e_percent: dict[str, float]
    still_percent: dict[str, float]
    nearest_percent: float
    still_nearest_percent: float
    chance_percent: float
    speed: float
    amplitude: float
    change: float
    ending: Ending


def measure(free: FreeRun) -> FreeRunMeasures:
    """Return the measures.

    Args:
        free: Postures from the release on, two repetitions or more.
    """
    still = np.broadcast_to(free.posture[0], free.posture.shape)
    nearest = nearest_over_time(free, free.posture)
    amplitude = _deviation(free.posture[-free.period :])
    before, last = free.posture[-2 * free.period : -free.period], free.posture[-free.period :]
    change = _rms(last - before) / max(amplitude, np.finfo(float).tiny)
    moved = amplitude / _deviation(free.reference[-free.period :])
    return FreeRunMeasures(
        held_s=_first(metrics.error_over_time(free.posture, free.reference) > HOLDING) / free.rate,
        near_s=_first(nearest > HOLDING) / free.rate,
        p_e_percent=_windows(free, free.posture),
        still_percent=_windows(free, still),
        nearest_percent=float(nearest.mean()),
        still_nearest_percent=float(nearest_over_time(free, still).mean()),
        chance_percent=_chance(free.reference[: free.period]),
        speed=_path(free.posture) / _path(free.reference),
        amplitude=moved,
        change=change,
        ending=_ending(moved, change),
    )


def as_markdown(found: Mapping[str, FreeRunMeasures]) -> str:
    """Return a table with a row for each run, by its name.

    Numbers in brackets are those of arms that stay where they are.
    """
    windows = [*(f"{window:g} s" for window in WINDOWS), "all"]
    head = ["run", "held, s", "near, s", *(f"p_e {window}, %" for window in windows)]
    head += ["chance, %", "nearest, %", "speed", "amplitude", "ends in"]
    rows = []
    for name, measures in found.items():
        times = [f"{measures.held_s:.2f}", f"{measures.near_s:.2f}"]
        errors = [
            _beside(measures.p_e_percent, measures.still_percent, window) for window in windows
        ]
        chance = f"{measures.chance_percent:.1f}"
        nearest = f"{measures.nearest_percent:.1f} ({measures.still_nearest_percent:.1f})"
        moved = [f"{measures.speed:.2f}", f"{measures.amplitude:.2f}", measures.ending]
        rows.append([name, *times, *errors, chance, nearest, *moved])
    return f"{markdown_table(head, rows)}\n\nin brackets: arms that stay where they are"


def _beside(errors: Mapping[str, float], still: Mapping[str, float], window: str) -> str:
    return f"{errors[window]:.2f} ({still[window]:.1f})" if window in errors else "–"


def nearest_over_time(free: FreeRun, posture: Array) -> Array:
    """Return the distance of postures from the nearest demonstrated one of the same label.

    Args:
        free: Demonstrated postures and labels.
        posture: Postures, shape (T, 12).

    Returns:
        Distances, shape (T,), percent.
    """
    nearest = np.empty(len(posture))
    for label in np.unique(free.label):
        part = free.label == label
        shown = free.reference[part]
        nearest[part] = [metrics.error_over_time(shown, x).min() for x in posture[part]]
    return nearest


def _windows(free: FreeRun, posture: Array) -> dict[str, float]:
    """Return the error over the windows that are not too long, and over all."""
    steps = {f"{window:g} s": round(window * free.rate) for window in WINDOWS}
    inside = {name: count for name, count in steps.items() if count <= len(posture)}
    return {
        name: metrics.posture_error_percent(posture[:count], free.reference[:count])
        for name, count in (inside | {"all": len(posture)}).items()
    }


def _chance(posture: Array) -> float:
    """Return the mean distance of all pairs of postures, shape (T, 12), percent."""
    return float(np.mean([metrics.posture_error_percent(posture, one) for one in posture]))


def _ending(amplitude: float, change: float) -> Ending:
    if amplitude < _STANDS:
        return "standstill"
    return "cycle" if change < _REPEATS else "wandering"


def _first(true: NDArray[np.bool_]) -> int:
    """Return the first step that is true, or the number of steps."""
    return int(true.argmax()) if true.any() else len(true)


def _deviation(posture: Array) -> float:
    return _rms(posture - posture.mean(axis=0))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _path(posture: Array) -> float:
    return float(np.linalg.norm(np.diff(posture, axis=0), axis=1).sum())


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
