"""Trajectories from the columns of a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import seconds_of
from mpma_mj.motions.readers.missing_samples import mark_missing
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.tables.people import refuse_alternating
from mpma_mj.motions.readers.tables.times import (
    Where,
    arrangement,
    continuous,
    may_be_times,
    rate_of,
)
from mpma_mj.motions.readers.text import Grid, stack

__all__ = ["Columns", "in_place", "load_columns", "neighbours", "rate_of_times", "suggest_times"]

Array = NDArray[np.float64]
Columns = Mapping[str, tuple[int, int, int]]
"""For each point the columns of x, y and z."""


def neighbours(first: Mapping[str, int]) -> Columns:
    """Return the columns of points of which y and z follow x.

    Args:
        first: For each point the column of x.
    """
    return {name: (x, x + 1, x + 2) for name, x in first.items()}


def load_columns(
    grid: Grid,
    columns: Columns,
    names: Sequence[str],
    report: ImportReport,
    *,
    frame_column: int | None = None,
    time_column: int | None = None,
) -> Tracks:
    """Read the trajectories of some points.

    Args:
        grid: The rows.
        columns: Columns of all points.
        names: Requested points.
        report: Gets what is odd about the rows.
        frame_column: Column of the frame's number, if there is one.
        time_column: Column of the frame's time, if there is one.

    Returns:
        Trajectories by name, each shape (T, 3), NaN where not seen.

    Raises:
        MotionFileError: There is no row, one cannot be read, or rows are of several people.
    """
    counter = [column for column in (time_column, frame_column) if column is not None]
    cells = counter + [column for name in names for column in columns[name]]
    blocks = grid.blocks(cells, report, counters=len(counter), placeholders=True)
    rows = stack(blocks, len(cells))
    if not len(rows):
        raise MotionFileError(
            f"{grid.file.path}: has a header but no frames; export the coordinates too"
        )
    times = None if time_column is None else continuous(rows[:, 0])
    numbers = None if frame_column is None else rows[:, len(counter) - 1]
    tracks = {name: rows[:, len(counter) + 3 * i :][:, :3] for i, name in enumerate(names)}
    return in_place(
        tracks, times, numbers, lambda row: f"line {grid.first + row + 1}", grid.file.path, report
    )


def in_place(
    tracks: Tracks,
    times: Array | None,
    numbers: Array | None,
    where: Where,
    path: Path,
    report: ImportReport,
) -> Tracks:
    """Return trajectories with gaps where a point was not seen, or a frame is missing.

    Args:
        tracks: Trajectories by name, each shape (T, 3), as the rows have them.
        times: Times of the rows, shape (T,), if there are some.
        numbers: Numbers of the frames, shape (T,), if there are some.
        where: Names a row.
        path: The file, for messages.
        report: Gets what is odd about the rows.

    Raises:
        MotionFileError: Rows are of several people.
    """
    mark_missing(tracks, report)
    refuse_alternating(path, tracks, numbers if times is None else times, where)
    arrange = arrangement(times, numbers, where, report)
    return tracks if arrange is None else {name: arrange(t) for name, t in tracks.items()}


def rate_of_times(
    grid: Grid,
    time_column: int,
    declared: float | None,
    report: ImportReport,
    unit: float | None = None,
) -> float | None:
    """Return the frame rate that a column of times shows; arguments as for `rate_of`."""
    blocks = grid.blocks([time_column], ImportReport(), counters=1)
    times = next(blocks, np.empty((0, 1)))[:, 0]
    return rate_of(continuous(times), declared, report, unit)


def suggest_times(
    grid: Grid, titles: Sequence[str], known: Sequence[int], report: ImportReport
) -> None:
    """Warn of a column that may hold times, in a table that has no column of times.

    Args:
        grid: The rows.
        titles: Title of every column.
        known: Columns that hold something else, between which there are no times.
        report: Gets the warning.
    """
    for column in {*range(min(known)), *range(max(known) + 1, grid.width)} - {*known}:
        if may_be_times(np.array([*map(seconds_of, grid.words(column))])):
            title = titles[column] if column < len(titles) else ""
            report.warn(
                f"column {column + 1}, {title or 'without a title'}, rises evenly; if it holds"
                " times, call it time",
                remedy="or give the rate with {rate_in}",
            )
            return
