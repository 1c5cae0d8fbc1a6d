"""Tables that hold x, y, z of every point in three neighbouring columns."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.text import Grid, stack

__all__ = ["load_columns", "rate_of_times"]

Array = NDArray[np.float64]

_DRIFT = 0.25  # frames
_UNEVEN, _OFTEN = 0.25, 0.05  # frames that a step is off; share of the steps (choice)
_LOOKED_AT = 4096  # first times, from which the rate and its rounding are estimated
_UNITS_OF_TIME = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
_FASTEST = 1000.0  # Hz that such times are taken to make
_MOST_MISSING = 10  # times as many frames as there are rows: then the numbers are wrong instead


def load_columns(
    grid: Grid,
    columns: dict[str, int],
    names: Sequence[str],
    report: ImportReport,
    *,
    frame_column: int | None = None,
    time_column: int | None = None,
) -> Tracks:
    """Read the trajectories of some points.

    Args:
        grid: The rows.
        columns: For each name the column of x; y and z follow.
        names: Requested points.
        report: Gets what is odd about the rows.
        frame_column: Column of the frame's number, if there is one: frames that it leaves out
            are gaps.
        time_column: Column of the frame's time, if there is one: it counts for more than the
            number, which often continues where frames were dropped.

    Returns:
        Trajectories by name, each shape (T, 3); not seen, or exactly 0, 0, 0, is NaN.

    Raises:
        MotionFileError: There is no row, or one cannot be read.
    """
    counter = [column for column in (time_column, frame_column) if column is not None]
    cells = counter + [columns[name] + axis for name in names for axis in range(3)]
    rows = stack(grid.blocks(cells, report, counters=len(counter)), len(cells))
    if not len(rows):
        raise MotionFileError(
            f"{grid.file.path}: has a header but no frames; export the coordinates too"
        )
    arrange = None
    if time_column is not None and _usable(rows[:, 0]):
        arrange = _by_times(rows[:, 0], grid, report)
    elif frame_column is not None:
        places = _places(rows[:, len(counter) - 1], grid, report)
        arrange = None if places is None else functools.partial(_placed, places=places)
    tracks = {}
    for i, name in enumerate(names):
        track = rows[:, len(counter) + 3 * i :][:, :3]
        track[(track == 0.0).all(axis=1)] = np.nan
        tracks[name] = track if arrange is None else arrange(track)
    return tracks


def _usable(times: Array) -> bool:
    """Return whether times, shape (T,), rise throughout."""
    return len(times) > 2 and bool((np.diff(times) > 0).all())


def _by_times(times: Array, grid: Grid, report: ImportReport) -> Callable[[Array], Array] | None:
    """Return what puts rows, shape (T, 3), to even times; None where they are as they should be.

    Args:
        times: Times of the rows, shape (T,), rising, in any unit.
        grid: The rows.
        report: Gets a warning of missing frames.
    """
    steps = np.diff(times)
    usual = _usual_step(times)
    if _come_unevenly(times):
        return functools.partial(_interpolated, times=times, step=usual)
    numbers = np.concatenate([[0.0], np.cumsum(_frames_of(steps, usual))])
    places = _places(numbers, grid, report)
    return None if places is None else functools.partial(_placed, places=places)


def _placed(track: Array, *, places: NDArray[np.int_]) -> Array:
    """Return a trajectory with gaps where rows are missing."""
    whole = np.full((places[-1] + 1, 3), np.nan)
    whole[places] = track
    return whole


def _usual_step(times: Array) -> float:
    """Return the mean of the steps that span one frame; a longer one spans missing ones."""
    steps = np.diff(times[:_LOOKED_AT])
    return float(steps[steps < 1.5 * np.median(steps)].mean())


def _frames_of(steps: Array, usual: float) -> Array:
    """Return how many frames each step spans, at least 1."""
    return np.maximum(1, np.round(steps / usual))


def _come_unevenly(times: Array) -> bool:
    """Return whether steps between times often differ from whole frames by more than rounding."""
    steps = np.diff(times)
    usual = _usual_step(times)
    off = np.abs(steps / usual - _frames_of(steps, usual))
    return bool(np.mean(off > _UNEVEN + _resolution(times) / usual) > _OFTEN)


def _resolution(times: Array) -> float:
    """Return the last decimal that times are written with."""
    some = times[:_LOOKED_AT]
    for decimals in range(7):
        unit = 10.0**-decimals
        if np.allclose(some / unit, np.round(some / unit), rtol=0.0, atol=1e-3):
            return unit
    return 0.0


def _interpolated(track: Array, *, times: Array, step: float) -> Array:
    """Return a trajectory at even times, by linear interpolation."""
    even = np.arange(times[0], times[-1] + 1e-3 * step, step)
    return np.stack([np.interp(even, times, column) for column in track.T], axis=1)


def rate_of_times(
    grid: Grid, time_column: int, declared: float | None, report: ImportReport
) -> float | None:
    """Return the frame rate that a column of times shows.

    Args:
        grid: The rows.
        time_column: Column of the times, s.
        declared: The rate that the header declares, Hz, if any.
        report: Gets a warning where the two contradict each other, or frames come unevenly.

    Returns:
        Frames per second, Hz: that of the times where they are usable, else the declared one.
    """
    blocks = grid.blocks([time_column], ImportReport(), counters=1)
    times = next(blocks, np.empty((0, 1)))[:, 0]
    steps = np.diff(times)
    if not _usable(times):
        return _coarse_rate(times, declared, report)
    rate = 1.0 / _usual_step(times)
    for unit, scale in _UNITS_OF_TIME.items():
        if rate < 1.0 <= scale * rate <= _FASTEST:
            rate, steps = scale * rate, steps / scale
            report.warn(f"the times are read as {unit}, which gives {rate:.4g} Hz")
            break
    if _come_unevenly(times):
        report.warn(
            f"the frames are unevenly spaced; they are interpolated to an even {rate:.4g} Hz"
        )
        return rate  # of the interpolation, whatever the header declares
    # Times are rounded, so that only a clear difference is one.
    if declared is not None and abs(rate - declared) < 0.02 * declared:
        return declared
    if declared is not None:
        report.warn(
            f"the header declares {declared:g} Hz, the times of the frames {rate:.4g} Hz;"
            f" {rate:.4g} Hz is used",
            remedy="{rate_in} overrides it",
        )
    # So are rates, unless that would gain or lose a good part of a frame.
    drift = abs(rate - round(rate)) * float(steps.sum())
    return rate if declared is not None or drift > _DRIFT else float(round(rate))


def _coarse_rate(times: Array, declared: float | None, report: ImportReport) -> float | None:
    """Return the rate where times do not rise from frame to frame."""
    if len(times) < 3:
        return declared
    span = float(times[-1] - times[0])
    if declared is None and span > 0 and (np.diff(times) >= 0).all():
        rate = (len(times) - 1) / span
        report.warn(
            f"the times are too coarse to distinguish frames; {rate:.4g} Hz is used, from the"
            " first and last time",
            remedy="{rate_in} overrides it",
        )
        return rate
    report.warn("the column of times does not ascend throughout; it is not used")
    return declared


def _places(numbers: Array, grid: Grid, report: ImportReport) -> NDArray[np.int_] | None:
    """Return where each row belongs, from its frame's number, or None for one after another."""
    steps = np.diff(numbers)
    usual = float(np.median(steps)) if len(steps) else 1.0
    even = (steps > 0) & (np.mod(steps, usual or 1.0) == 0)  # not where a number is missing
    if not even.all():
        bad = int(np.argmin(even))
        report.warn(
            f"the frame numbers jump at line {grid.first + bad + 2}; rows are treated as"
            " consecutive"
        )
        return None
    places = ((numbers - numbers[0]) / usual).astype(int)
    missing = places[-1] + 1 - len(places)
    if not missing:
        return None
    if missing > _MOST_MISSING * len(places):
        report.warn(
            f"the frame numbers omit {missing} frames of {places[-1] + 1}; rows are treated as"
            " consecutive"
        )
        return None
    first = int(np.argmax(np.diff(places) > 1))
    report.warn(
        f"{missing} frames are missing, the first after line {grid.first + first + 1}; they are"
        " treated as gaps"
    )
    return places
