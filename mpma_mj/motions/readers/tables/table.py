"""Reader for tables with a header: x, y, z of named points in columns.

Exports vary: one header row (`left_wrist_x`, `LWRI.X`, `x11`, …) or several (names above X, Y, Z),
in any order of axes, with rows of types, identifiers and units around, as OptiTrack, Vicon and
Captury write them. What matters is found by content: the row with the axes, the row with the
names, the first row of numbers.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Recording
from mpma_mj.motions.readers.tables.columns import (
    Columns,
    load_columns,
    rate_of_times,
    suggest_times,
)
from mpma_mj.motions.readers.tables.header import Header, find_header, names_axes
from mpma_mj.motions.readers.tables.long_table import is_long, read_long
from mpma_mj.motions.readers.tables.motive import rename_bones
from mpma_mj.motions.readers.tables.numbered_points import name_numbered
from mpma_mj.motions.readers.tables.people import refuse_several
from mpma_mj.motions.readers.tables.titles import is_person, split_axis, time_unit
from mpma_mj.motions.readers.text import Grid, TextFile
from mpma_mj.utils.text import listing

__all__ = ["read_table"]

_MOST_LISTED = 5  # names in a warning


def read_table(file: TextFile, report: ImportReport) -> Recording:
    """Read the header of a table.

    Raises:
        MotionFileError: No row names the columns of x, y and z, or rows are of several people.
    """
    header = find_header(file, names_axes)
    if header is None:
        raise MotionFileError(
            f"{file.path}: is no recording of a known format, and no header row names columns such"
            " as left_wrist_x, left_wrist_y, left_wrist_z; export as C3D, BVH, ASF/AMC, TRC,"
            " Qualisys TSV or CSV with a header"
        )
    grid = Grid.starting(file, header.start + header.first, columns=header.width)
    if is_long(header):
        return read_long(header, grid, report)
    columns, names = _columns(file.path, header, report)
    titles = header.titles
    counter, timer = header.counters
    rate = header.rate
    if header.first < len(header.rows):
        needed = [c for xyz in columns.values() for c in xyz]
        needed += [c for c in (counter, timer) if c is not None]
        header.check_width(grid, needed)
        for column in (i for i, title in enumerate(titles[: grid.width]) if is_person(title)):
            refuse_several(file.path, titles[column], grid.words(column))
        if timer is not None:
            rate = rate_of_times(grid, timer, rate, report, time_unit(titles[timer]))
        elif rate is None:
            suggest_times(grid, titles, needed, report)
    recording = Recording(
        file.path,
        "table",
        names,
        lambda names: load_columns(
            grid, columns, names, report, frame_column=counter, time_column=timer
        ),
        rate=rate,
        unit=header.unit([x for x, _, _ in columns.values()]),
        up=header.up,
        frames=header.frames,
    )
    return name_numbered(recording, report)


def _columns(path: Path, header: Header, report: ImportReport) -> tuple[Columns, tuple[str, ...]]:
    """Return the columns of every point, and the points' names in order."""
    found: dict[str, dict[str, list[int]]] = {}
    titled = _titled(header)
    rename_bones(titled, header, report)
    for column, (name, axis) in titled.items():
        found.setdefault(name, {"x": [], "y": [], "z": []})[axis].append(column)
    columns, names = {}, []
    for name, (x, y, z) in ((name, axes.values()) for name, axes in found.items()):
        if x and y and z:
            columns[name] = (x[0], y[0], z[0])
            names += [name] * min(len(x), len(y), len(z))  # twice is refused if it is needed
    if not columns:
        _refuse_no_places(
            path, header, {axis for axes in found.values() for axis in axes if axes[axis]}
        )
    _warn_of_disorder(columns, report)
    incomplete = [name for name, axes in found.items() if name not in columns]
    if header.name_row is not None and columns and incomplete:
        listed = listing(incomplete, _MOST_LISTED)
        report.warn(f"{listed} are not above an x, a y and a z each; check the row of names")
    elif columns and any(found[name]["z"] for name in incomplete):  # only x and y: of a picture
        listed = ", ".join([name for name in incomplete if found[name]["z"]][:_MOST_LISTED])
        report.warn(f"{listed} has a z, but not both x and y; check the titles")
    return columns, tuple(names)


def _refuse_no_places(path: Path, header: Header, axes: set[str]) -> None:
    """Refuse a table of which no point is in space, if it says why; `axes` are those of points."""
    if axes == {"x", "y"}:
        raise MotionFileError(f"{path}: has x and y of points, but no z; export places in space")
    if axes:
        raise MotionFileError(f"{path}: no point has x, y and z; check the titles of the columns")
    if any(map(header.is_no_place, range(len(header.rows[header.axes])))):
        raise MotionFileError(
            f"{path}: its columns of x, y, z hold rotations, speeds or pixels; export places in"
            " space"
        )


def _warn_of_disorder(columns: Columns, report: ImportReport) -> None:
    """Warn of points whose columns are in another order than most: a title may be wrong."""
    ways = {name: (y - x, z - x) for name, (x, y, z) in columns.items()}
    usual, count = Counter(ways.values()).most_common(1)[0] if ways else ((0, 0), 0)
    if len(ways) > count > 1:
        other = listing([name for name, way in ways.items() if way != usual], _MOST_LISTED)
        report.warn(
            f"the columns of {other} are in another order than those of other points; check their"
            " titles"
        )


def _titled(header: Header) -> dict[int, tuple[str, str]]:
    """Return for each column of a coordinate the point's name and the axis.

    A name counts until the next one, or until an axis is repeated: the columns after it have no
    name. Names may also stand above the middle of their axes.
    """
    titled: dict[int, tuple[str, str]] = {}
    row = header.name_row
    axes = header.rows[header.axes]
    first = next(column for column, title in enumerate(axes) if split_axis(title)[1])
    names = () if row is None else header.rows[row][first : first + 3]
    late = next((i for i, name in enumerate(names) if name), 0)
    shared, seen = "", set[str]()
    for column, title in enumerate(axes):
        if row is not None and (cell := header.cell(row, column + late)):
            shared, seen = cell, set()
        own, axis = split_axis(title)
        if not axis or header.is_no_place(column):
            continue
        name = own if own and not (own.isdigit() and shared) else shared
        if name and not (name == shared and axis in seen):
            titled[column] = name, axis
        seen.add(axis)
    return titled
