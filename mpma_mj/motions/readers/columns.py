"""Tables that hold x, y, z of every point in three neighbouring columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.findings import Findings
from mpma_mj.motions.readers.text import Grid, stack
from mpma_mj.motions.recording import Tracks

__all__ = ["load_columns", "rate_of_times"]

Array = NDArray[np.float64]

_DRIFT = 0.25  # frames
_MOST_MISSING = 10  # times as many frames as there are rows: then the numbers are wrong instead


def load_columns(
    grid: Grid,
    columns: dict[str, int],
    names: Sequence[str],
    findings: Findings,
    *,
    frame_column: int | None = None,
) -> Tracks:
    """Read the trajectories of some points.

    Args:
        grid: The rows.
        columns: For each name the column of x; y and z follow.
        names: Points that are wanted.
        findings: Is told what is odd about the rows.
        frame_column: Column of the frame's number, if there is one: frames that it leaves out
            are gaps.

    Returns:
        Trajectories by name, each shape (T, 3); not seen, or exactly 0, 0, 0, is NaN.

    Raises:
        MotionFileError: There is no row, or one cannot be read.
    """
    counter = [] if frame_column is None else [frame_column]
    wanted = counter + [columns[name] + axis for name in names for axis in range(3)]
    rows = stack(grid.blocks(wanted, findings), len(wanted))
    if not len(rows):
        raise MotionFileError(
            f"{grid.file.path}: has a header but no frames; export the coordinates too"
        )
    places = _places(rows[:, 0], grid, findings) if counter else None
    tracks = {}
    for i, name in enumerate(names):
        track = rows[:, len(counter) + 3 * i :][:, :3]
        track[(track == 0.0).all(axis=1)] = np.nan
        if places is not None:
            whole = np.full((places[-1] + 1, 3), np.nan)
            whole[places] = track
            track = whole
        tracks[name] = track
    return tracks


def rate_of_times(
    grid: Grid, time_column: int, declared: float | None, findings: Findings
) -> float | None:
    """Return the frame rate that a column of times shows.

    Args:
        grid: The rows.
        time_column: Column of the times, s.
        declared: The rate that the header tells, Hz, if it does.
        findings: Is told where the two contradict each other, or frames come unevenly.

    Returns:
        Frames per second, Hz: that of the times where they are usable, else the declared one.
    """
    times = next(grid.blocks([time_column], Findings()), np.empty((0, 1)))[:, 0]
    steps = np.diff(times)
    if len(steps) < 2 or not (steps > 0).all():
        if len(steps) >= 2:
            findings.warn("the column of times does not rise throughout; it is not used")
        return declared
    usual = np.median(steps)
    regular = steps < 1.5 * usual  # a longer one spans frames that are missing
    rate = float(regular.sum() / steps[regular].sum())
    if np.abs(steps[regular] - usual).max() > 0.5 * usual:
        findings.warn(f"the frames come unevenly; they are taken as even, at {rate:.4g} Hz")
    # Times are rounded, so that only a clear difference is one.
    if declared is not None and abs(rate - declared) < 0.02 * declared:
        return declared
    if declared is not None:
        findings.warn(
            f"the header says {declared:g} Hz, the frames' times {rate:.4g} Hz; {rate:.4g} Hz is"
            " used (--rate-in overrides it)"
        )
    # So are rates, unless that would gain or lose a good part of a frame.
    drift = abs(rate - round(rate)) * float(steps.sum())
    return rate if declared is not None or drift > _DRIFT else float(round(rate))


def _places(numbers: Array, grid: Grid, findings: Findings) -> NDArray[np.int_] | None:
    """Return where each row belongs, from its frame's number, or None for one after another."""
    steps = np.diff(numbers)
    usual = float(np.median(steps)) if len(steps) else 1.0
    even = (steps > 0) & (np.mod(steps, usual or 1.0) == 0)  # not where a number is missing
    if not even.all():
        bad = int(np.argmin(even))
        findings.warn(
            f"the frame numbers jump at line {grid.first + bad + 2}; rows are taken as following"
            " one another"
        )
        return None
    places = ((numbers - numbers[0]) / usual).astype(int)
    missing = places[-1] + 1 - len(places)
    if not missing:
        return None
    if missing > _MOST_MISSING * len(places):
        findings.warn(
            f"the frame numbers leave out {missing} frames of {places[-1] + 1}; rows are taken"
            " as following one another"
        )
        return None
    first = int(np.argmax(np.diff(places) > 1))
    findings.warn(
        f"{missing} frames are missing, the first after line {grid.first + first + 1}; they are"
        " treated as gaps"
    )
    return places
