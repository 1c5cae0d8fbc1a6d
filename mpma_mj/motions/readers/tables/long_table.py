"""Reader for long tables: a row holds one point in one frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import is_number
from mpma_mj.motions.readers.recording import Recording, Tracks
from mpma_mj.motions.readers.tables.columns import in_place
from mpma_mj.motions.readers.tables.header import Header
from mpma_mj.motions.readers.tables.numbered_points import name_numbered
from mpma_mj.motions.readers.tables.people import refuse_several
from mpma_mj.motions.readers.tables.times import continuous, rate_of
from mpma_mj.motions.readers.tables.titles import (
    is_no_place,
    is_person,
    is_point,
    split_axis,
    time_unit,
)
from mpma_mj.motions.readers.text import Grid, stack

__all__ = ["is_long", "read_long"]


def is_long(header: Header) -> bool:
    """Return whether a table has one column of x, and one that names the point."""
    return _axes(header).count("x") == 1 and any(map(is_point, header.rows[header.axes]))


def read_long(header: Header, grid: Grid, report: ImportReport) -> Recording:
    """Read a long table.

    Raises:
        MotionFileError: No column has the frame, a frame has a point twice, or rows are of
            several people.
    """
    path, titles = grid.file.path, header.rows[header.axes]
    axes = _axes(header)
    columns = [axes.index(axis) for axis in "xyz"]
    counter, timer = header.counters
    if counter is None and timer is None:
        raise MotionFileError(
            f"{path}: has one point a row, and no column of its frame or time; add a column frame"
        )
    points = _names(header, grid)
    for column, title in enumerate(titles):
        if is_person(title) and not is_point(title):
            refuse_several(path, title, grid.words(column))
    counters = [column for column in (timer, counter) if column is not None]
    cells = counters + columns
    blocks = grid.blocks(cells, report, counters=len(counters), placeholders=True)
    rows = stack(blocks, len(cells))
    known = np.isfinite(rows[:, : len(counters)]).all(axis=1)
    if not known.all():
        line = grid.first + int(np.argmin(known)) + 1
        raise MotionFileError(
            f"{path}: line {line} has no frame or time; correct that line, or delete it"
        )
    # The frame's number, which may be the only thing that all its rows share, else its time.
    frames, first, frame = np.unique(
        rows[:, len(counters) - 1], return_index=True, return_inverse=True
    )
    names = tuple(dict.fromkeys(points))
    index = np.array([names.index(name) for name in points], int)
    _refuse_twice(points, frame * len(names) + index, grid)
    times = None if timer is None else continuous(rows[first, 0])

    def load(chosen: Sequence[str]) -> Tracks:
        tracks = {}
        for name in chosen:
            tracks[name] = np.full((len(frames), 3), np.nan)
            own = index == names.index(name)
            tracks[name][frame[own]] = rows[own, -3:]
        numbers = None if counter is None else frames
        return in_place(tracks, times, numbers, lambda i: f"frame {frames[i]:g}", path, report)

    rate = header.rate
    if times is not None and timer is not None:
        rate = rate_of(times, rate, report, time_unit(header.titles[timer]))
    recording = Recording(
        path, "long table", names, load, rate=rate, unit=header.unit(columns), up=header.up
    )
    return name_numbered(recording, report)


def _axes(header: Header) -> list[str]:
    """Return the axis of places that each column holds, "" for another one."""
    return ["" if is_no_place(t) else split_axis(t)[1] for t in header.rows[header.axes]]


def _names(header: Header, grid: Grid) -> list[str]:
    """Return the name of each row's point, rather in words than by number."""
    titles = header.rows[header.axes]
    found = [grid.words(column) for column, title in enumerate(titles) if is_point(title)]
    return next((names for names in found if not all(map(is_number, names))), found[0])


def _refuse_twice(points: list[str], keys: np.ndarray, grid: Grid) -> None:
    """Refuse rows of the same frame and point, that is with equal `keys`, shape (rows,)."""
    _, first = np.unique(keys, return_index=True)
    if len(first) < len(keys):
        again = np.ones(len(keys), bool)
        again[first] = False
        row = int(np.argmax(again))
        raise MotionFileError(
            f"{grid.file.path}: line {grid.first + row + 1} has {points[row]} again in"
            " the same frame, as that of another person; keep the rows of one"
        )
