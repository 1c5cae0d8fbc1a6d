"""Rows above the numbers of a table, and what they declare about the recording."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers.cells import is_missing, is_number, positive
from mpma_mj.motions.readers.recording import Up
from mpma_mj.motions.readers.tables.titles import (
    RATE,
    is_frame,
    is_no_place,
    is_point,
    is_rate,
    is_time,
    length_unit,
    may_be_time,
    split_axis,
)
from mpma_mj.motions.readers.text import Grid, TextFile

__all__ = ["Header", "find_header", "names_axes"]

_LONGEST = 60  # lines
_FEWEST_POINTS = 2
_FEWEST_NUMBERS = 6  # in a row, with which it is one of the table and not of the header
_OTHER_SECTIONS = {"Devices", "Events", "Joints", "Model Outputs", "Segments"}
_RATE_IN_CELL = re.compile(rf"\W*{RATE}[\s:;=]*(?P<value>[\d.]+)\s*(hz|fps)?", re.IGNORECASE)
_RATE_ALONE = re.compile(r"\W*(?P<value>\d[\d.]*)\W*(hz|fps|frames per second)?\W*", re.IGNORECASE)
_FRAMES_TITLE = re.compile(r"(number of |total )?(exported )?frames", re.IGNORECASE)


@dataclass(frozen=True)
class Header:
    """The rows above the numbers, cell by cell.

    Attributes:
        rows: The rows; the last ones are already numbers.
        axes: Index of the row with the axes.
        first: Index of the first row of numbers; that of the last row + 1 if there is none.
        start: Index of the first row's line in the file.
    """

    rows: list[list[str]]
    axes: int
    first: int
    start: int

    @property
    def width(self) -> int:
        """Number of columns up to the last title in the row with the axes."""
        titles = self.rows[self.axes]
        return max((i + 1 for i, title in enumerate(titles) if title), default=0)

    def cell(self, row: int, column: int) -> str:
        """Return a cell, "" beyond the end of its row."""
        cells = self.rows[row]
        return cells[column] if column < len(cells) else ""

    def is_no_place(self, column: int) -> bool:
        """Return whether a cell from a column's name on says that it holds no places."""
        names = self.name_row
        rows = range(self.axes if names is None else min(names, self.axes), self.first)
        return any(is_no_place(self.cell(row, column)) for row in (*rows, self.axes))

    @functools.cached_property
    def name_row(self) -> int | None:
        """Index of the row that names the points: above the axes, or between them and numbers."""
        above = range(self.axes - 1, -1, -1)
        for index in above:
            if any(cell.lower() == "name" for cell in self.rows[index][:2]):
                return index
        for index in (*above, *range(self.axes + 1, self.first)):
            words = {cell for cell in self.rows[index] if cell and not is_number(cell)}
            if len(words) >= _FEWEST_POINTS and not any(map(length_unit, words)):
                return index
        return None

    @property
    def titles(self) -> list[str]:
        """Title of every column: that of times or frames, if a cell has one, else the first."""
        rows = [*range(self.axes, self.first), *range(max(0, self.axes - 1), self.axes)]
        width = max(map(len, self.rows[: self.first]))
        columns = [[self.cell(row, column) for row in rows] for column in range(width)]
        tests = (lambda c: is_time(c) or is_frame(c), may_be_time)
        return [
            next((c for test in tests for c in cells if test(c)), cells[0]) for cells in columns
        ]

    @property
    def counters(self) -> tuple[int | None, int | None]:
        """Columns of the frame's number and of its time, where there are such."""
        titles = self.titles
        frame = next((i for i, title in enumerate(titles) if is_frame(title)), None)
        times = (i for is_one in (is_time, may_be_time) for i, t in enumerate(titles) if is_one(t))
        return frame, next(times, None)

    @property
    def rate(self) -> float | None:
        """Declared rate, Hz: that of the export rather than that of the capture."""
        captured, found = None, None
        for row in self.rows[: self.axes]:
            cells = [cell.replace(",", ".") for cell in row if cell]
            for title, value in itertools.pairwise([*cells, ""]):
                number = None
                if is_rate(title) and (alone := _RATE_ALONE.fullmatch(value)):
                    number = positive(alone["value"])
                elif inside := _RATE_IN_CELL.fullmatch(title):
                    number = positive(inside["value"])
                if title.lower().startswith("capture"):
                    captured = captured or number
                else:
                    found = number or found
            alone = _RATE_ALONE.fullmatch(" ".join(cells))  # Vicon: nothing but the rate
            if alone is not None:
                found = found or positive(alone["value"])
        return found or captured

    @property
    def frames(self) -> int | None:
        """Declared number of frames."""
        pairs = (pair for row in self.rows[: self.axes] for pair in itertools.pairwise(row))
        found = [positive(value) for title, value in pairs if _FRAMES_TITLE.fullmatch(title)]
        return next((int(number) for number in reversed(found) if number), None)

    @property
    def up(self) -> Up | None:
        """Axis that points up: y in OptiTrack's tables, which name their coordinate space."""
        top = {cell.lower() for row in self.rows[: self.axes] for cell in row}
        return "y" if "coordinate space" in top else None

    def check_width(self, grid: Grid, needed: Sequence[int]) -> None:
        """Refuse rows that have too few columns, or titles that are shifted.

        Captury has columns without a title at the end. One more is R's names of the rows, and with
        commas between cells, more are decimal commas.

        Args:
            grid: The rows.
            needed: Columns that are read.

        Raises:
            MotionFileError: The rows have fewer columns than the header, or one more.
        """
        more = grid.width - max(len(row) for row in self.rows[: self.first])
        if grid.width <= max(needed) or more == 1 or (more > 0 and grid.separator == ","):
            raise MotionFileError(
                f"{grid.file.path}: line {grid.first + 1} has {grid.width} columns, but the header"
                f" names {len(self.rows[self.axes])}; export the file again"
            )

    def unit(self, columns: Sequence[int]) -> float | None:
        """Return the declared length of the unit, m.

        Args:
            columns: Columns of coordinates.
        """
        cells = [self.cell(row, column) for column in columns for row in range(self.first)]
        for row in self.rows[: self.axes]:
            cells += [v for k, v in itertools.pairwise(row) if k.lower() == "length units"]
        return next((unit for cell in cells if (unit := length_unit(cell)) is not None), None)


def find_header(file: TextFile, is_title_row: Callable[[list[str]], bool]) -> Header | None:
    """Find the header of a table by the row with the titles of its columns.

    Args:
        file: The table.
        is_title_row: Returns whether a row, cell by cell, is the one.

    Raises:
        MotionFileError: Rows of numbers are above it.
    """
    start = _section(file)
    head = itertools.islice(file.lines(start), _LONGEST)
    lines = [line.replace('"', "") for line in head]
    for index in range(len(lines)):
        for separator in ("\t", ";", ",", None):
            if not is_title_row([cell.strip() for cell in lines[index].split(separator)]):
                continue
            rows = [[cell.strip() for cell in line.split(separator)] for line in lines]
            _refuse_numbers_above(file, rows[:index], start)
            return Header(rows, index, _first_numbers(rows, index), start)
    return None


def names_axes(cells: list[str]) -> bool:
    """Return whether a row names the axes of several points, or of one that a column names."""
    axes = [split_axis(cell)[1] for cell in cells]
    if axes.count("x") >= _FEWEST_POINTS and "y" in axes:
        return True
    return all(axes.count(axis) == 1 for axis in "xyz") and any(map(is_point, cells))


def _section(file: TextFile) -> int:
    """Return the index of the line where Vicon's trajectories begin, after its other sections."""
    first = next(iter(file.head(1)), "").strip(' ",;\t')
    if first not in _OTHER_SECTIONS:
        return 0
    lines = enumerate(file.lines())
    return next((i for i, line in lines if line.lstrip('"').startswith("Trajectories")), 0)


def _first_numbers(rows: list[list[str]], axes: int) -> int:
    """Return the index of the first row of numbers after the axes."""
    for index in range(axes + 1, len(rows)):
        cells = [cell for cell in rows[index] if cell]
        numbers = sum(is_number(cell.replace(",", ".")) or is_missing(cell) for cell in cells)
        if cells and 2 * numbers > len(cells):
            return index
    return len(rows)


def _refuse_numbers_above(file: TextFile, rows: list[list[str]], start: int) -> None:
    """Refuse rows of a table above its header; one of whole numbers may count the columns."""
    tabular = []
    for index, row in enumerate(rows):
        cells = [cell for cell in row if cell]
        if len(cells) >= _FEWEST_NUMBERS and all(is_number(c) or is_missing(c) for c in cells):
            tabular += [index] * (2 - all(cell.isdigit() for cell in cells))
    if len(tabular) > 1:
        raise MotionFileError(
            f"{file.path}: line {start + tabular[0] + 1} has numbers above the header in line"
            f" {start + len(rows) + 1}; move the header to the top, or delete those lines"
        )
