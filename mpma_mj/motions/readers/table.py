"""Reader for tables with a header: x, y, z of named points in three columns each.

Exports vary: one header row (`left_wrist_x`, `LWRI.X`, …) or several (names above X, Y, Z), with
rows of types, identifiers and units around, as OptiTrack, Vicon and Captury write them. What
matters is found by content: the row with the axes, the row with the names, the first row of
numbers.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.columns import load_columns, neighbours, rate_of_times
from mpma_mj.motions.readers.recording import UNITS, Recording, Up
from mpma_mj.motions.readers.text import Grid, TextFile, is_number, positive

__all__ = ["read_table"]

_LONGEST_HEADER = 60  # lines
_FEWEST_POINTS = 2
_AXIS = re.compile(r"(?P<name>.*?)[\s_.:\-(\[]*(?P<axis>[xyzXYZ])\d*[)\]]?\s*(?:[(\[]\w+[)\]])?$")
_RATE = re.compile(
    r"(frame|data|camera|sample|sampling)?\s*_?(rate|frequency|fps)(\s*\(?hz\)?)?", re.I
)
_TIME = re.compile(
    r"(elapsed[\s_]*)?(t|time|timestamp|zeit|seconds)"
    r"([\s_(\[]*([mun]?s|[mun]?sec|(milli|micro|nano)?seconds)[)\]]?)?",
    re.I,
)
_FRAMES = {"frame", "frame#", "frames", "frame number", "frame_number", "index"}
_OTHER_SECTIONS = {"Devices", "Events", "Joints", "Model Outputs", "Segments"}
_LENGTHS = {
    **{"m": "m", "meter": "m", "meters": "m", "metres": "m"},
    **{"cm": "cm", "centimeters": "cm", "mm": "mm", "millimeters": "mm", "inches": "inch"},
}


@dataclass(frozen=True)
class _Header:
    """The rows above the numbers, cell by cell, and which of them holds the axes."""

    rows: list[list[str]]
    axes: int  # index of the row with the axes
    start: int  # index of the first row's line in the file

    def cell(self, row: int, column: int) -> str:
        cells = self.rows[row]
        return cells[column] if column < len(cells) else ""

    def column_has(self, column: int, words: set[str], rows: range) -> bool:
        return any(self.cell(row, column).lower() in words for row in rows)


def read_table(file: TextFile, report: ImportReport) -> Recording:
    """Read the header of a table.

    Raises:
        MotionFileError: No row names the columns of x, y and z.
    """
    header = _find_header(file)
    first = _first_numbers(header)
    columns, names = _columns(header, first)
    titles = [cell.lower() for cell in header.rows[header.axes]]
    line = header.start + first  # index of the first row of numbers in the file
    grid = Grid.starting(file, line)
    rate = _declared(header, _RATE)
    counter = next((i for i, title in enumerate(titles) if title in _FRAMES), None)
    timer = next((i for i, title in enumerate(titles) if _TIME.fullmatch(title)), None)
    if first < len(header.rows):
        needed = [x + 2 for x in columns.values()] + [c for c in (counter, timer) if c is not None]
        fewest = max(needed, default=0) + 1
        # Captury has columns without a title at the end. One more is R's names of the rows, and
        # with commas between cells, more are decimal commas: then the titles are shifted.
        more = grid.width - max(len(row) for row in header.rows[:first])
        if grid.width < fewest or more == 1 or (more > 0 and grid.separator == ","):
            raise MotionFileError(
                f"{file.path}: line {line + 1} has {grid.width} columns, but the header names"
                f" {len(header.rows[header.axes])}; export the file again"
            )
        if timer is not None:
            rate = rate_of_times(grid, timer, rate, report)
    frames = _declared(header, re.compile(r"(number of |total )?(exported )?frames", re.I))
    return Recording(
        file.path,
        "table",
        names,
        lambda names: load_columns(
            grid, neighbours(columns), names, report, frame_column=counter, time_column=timer
        ),
        rate=rate,
        unit=_unit(header, columns, first),
        up=_up(header),
        frames=int(frames) if frames else None,
    )


def _find_header(file: TextFile) -> _Header:
    """Return the header's rows; their last lines are already numbers."""
    start = _section(file)
    head = itertools.islice(file.lines(start), _LONGEST_HEADER)
    lines = [line.replace('"', "") for line in head]
    for index in range(len(lines)):
        for separator in ("\t", ";", ",", None):
            cells = [cell.strip() for cell in lines[index].split(separator)]
            if sum(_axis(cell) == "x" for cell in cells) < _FEWEST_POINTS:
                continue
            rows = [[cell.strip() for cell in line.split(separator)] for line in lines]
            return _Header(rows, index, start)
    raise MotionFileError(
        f"{file.path}: is no recording of a known format, and no header row names columns such as"
        " left_wrist_x, left_wrist_y, left_wrist_z; export as C3D, BVH, ASF/AMC, TRC, Qualisys"
        " TSV or CSV with a header"
    )


def _section(file: TextFile) -> int:
    """Return the index of the line where Vicon's trajectories begin, after its other sections."""
    first = next(iter(file.head(1)), "").strip(' ",;\t')
    if first not in _OTHER_SECTIONS:
        return 0
    lines = enumerate(file.lines())
    return next((i for i, line in lines if line.lstrip('"').startswith("Trajectories")), 0)


def _axis(cell: str) -> str:
    """Return "x", "y" or "z" if a column's title ends in it, else ""."""
    found = _AXIS.fullmatch(cell)
    if found is None or (found["name"] and found["name"][-1].isalpha() and _joined(cell, found)):
        return ""
    return found["axis"].lower()


def _joined(cell: str, found: re.Match[str]) -> bool:
    """Return whether the axis is the end of a word, as in "index", and not set off: LWristX."""
    axis = found.start("axis")
    return (
        axis > 0
        and cell[axis - 1].isalpha()
        and not (cell[axis].isupper() and cell[axis - 1].islower())
    )


def _first_numbers(header: _Header) -> int:
    """Return the index of the first row of numbers after the axes."""
    for index in range(header.axes + 1, len(header.rows)):
        cells = [cell for cell in header.rows[index] if cell]
        numbers = sum(is_number(cell.replace(",", ".")) for cell in cells)
        if cells and 2 * numbers > len(cells):
            return index
    return len(header.rows)


def _columns(header: _Header, first: int) -> tuple[dict[str, int], tuple[str, ...]]:
    """Return the column of x of every point, and the points' names in order."""
    axes = [_axis(cell) for cell in header.rows[header.axes]]
    above = _name_row(header)
    around = range(max(0, header.axes - 6), first)
    columns: dict[str, int] = {}
    names = []
    for x in range(len(axes) - 2):
        if axes[x : x + 3] != ["x", "y", "z"]:
            continue
        if header.column_has(x, {"rotation", "quaternion", "deg", "rad", "°"}, around):
            continue
        found = _AXIS.fullmatch(header.cell(header.axes, x))
        name = found["name"] if found else ""
        if not name and above is not None:
            name = next(filter(None, (header.cell(above, x + i) for i in range(3))), "")
        if name:
            names.append(name)
            columns.setdefault(name, x)
    return columns, tuple(names)


def _name_row(header: _Header) -> int | None:
    """Return the index of the row above the axes that names the points."""
    for index in range(header.axes - 1, -1, -1):
        if any(cell.lower() == "name" for cell in header.rows[index][:2]):
            return index
    for index in range(header.axes - 1, -1, -1):
        words = {cell for cell in header.rows[index] if cell and not is_number(cell)}
        if len(words) >= _FEWEST_POINTS:
            return index
    return None


def _declared(header: _Header, title: re.Pattern[str]) -> float | None:
    """Return the number that follows a title in the rows above the axes."""
    found = None
    for row in header.rows[: header.axes]:
        cells = [cell.replace(",", ".") for cell in row]
        for key, value in zip(row, [*cells[1:], ""], strict=True):
            if title.fullmatch(key.removeprefix("Export ")):
                found = positive(value) or found
            elif title.fullmatch(key.removeprefix("Capture ")):
                found = found or positive(value)
        if title is _RATE and [c for c in cells if c] == cells[:1]:
            found = found or positive(cells[0])  # Vicon: a line with nothing but the rate
    return found


def _unit(header: _Header, columns: dict[str, int], first: int) -> float | None:
    """Return the length of the unit that stands in the header, m."""
    cells = [header.cell(row, x) for x in columns.values() for row in range(first)]
    titles = [header.cell(header.axes, x) for x in columns.values()]
    cells += [word for title in titles for word in re.findall(r"[(\[](\w+)[)\]]", title)]
    for row in header.rows[: header.axes]:
        cells += [v for k, v in itertools.pairwise(row) if k.lower() == "length units"]
    return next((UNITS[_LENGTHS[c.lower()]] for c in cells if c.lower() in _LENGTHS), None)


def _up(header: _Header) -> Up | None:
    """OptiTrack's tables, which name their coordinate space, have y up."""
    top = {cell.lower() for row in header.rows[: header.axes] for cell in row}
    return "y" if "coordinate space" in top else None
