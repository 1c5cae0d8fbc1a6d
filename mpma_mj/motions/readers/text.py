"""Text files of numbers, read row by row: a long recording need not fit into memory.

Our own reader, as `pandas.read_csv` (3.1) accepts a row that is cut short, passes over empty lines
and names no line or column; for blocks of checked rows it takes as long as `numpy.loadtxt` (0.89 s
and 0.92 s for an hour at 60 Hz, 18 columns), and its import takes 0.5 s and 41 MB.
"""

from __future__ import annotations

import functools
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import (
    is_missing,
    is_number,
    is_timecode,
    seconds_of,
    timecode_rate,
)
from mpma_mj.motions.readers.encodings import encoding_of

__all__ = [
    "FARTHEST",
    "LONGEST_LINE",
    "Grid",
    "TextFile",
    "stack",
]

Array = NDArray[np.float64]

FARTHEST = 1e9
"""What is farther away, in any unit, is no coordinate."""
LONGEST_LINE = 1 << 23
"""Characters that a line has at most, which bounds what is held of a file without lines."""

_LONGEST_HEAD = 1 << 20  # characters of a line of the header
_HEAD = 65536  # bytes from which the encoding is detected
_BLOCK = 4096  # rows that are turned into numbers at once
_LOOK = 20  # rows from which the number format is detected
_QUOTED_COMMA = re.compile(r'"([-+]?\d*),(\d+)"')  # which is decimal: commas separate cells


@dataclass(frozen=True)
class TextFile:
    """A text file and how its letters are stored.

    Attributes:
        path: The file.
        encoding: Name of the encoding.
        ends_whole: Whether its last line has an end; where not, the line may be cut.
    """

    path: Path
    encoding: str
    ends_whole: bool

    @classmethod
    def open(cls, path: Path) -> TextFile | None:
        """Return the file, or None if it holds no text."""
        with path.open("rb") as file:
            head = file.read(_HEAD)
            file.seek(max(0, file.seek(0, 2) - 2))
            tail = file.read().rstrip(b"\0")  # half of a letter in UTF-16
        encoding = encoding_of(head)
        if encoding is None:
            return None
        return cls(path, encoding, tail.endswith((b"\n", b"\r")))

    def lines(self, first: int = 0) -> Iterator[str]:
        """Iterate over the lines, without their ends, from the one with index `first`.

        Raises:
            MotionFileError: A line is longer than `LONGEST_LINE`.
        """
        with self.path.open(encoding=self.encoding, errors="replace") as file:
            pieces = iter(functools.partial(file.readline, LONGEST_LINE), "")
            for number, line in enumerate(pieces, 1):
                if len(line) == LONGEST_LINE:
                    raise MotionFileError(
                        f"{self.path}: line {number} has more than {LONGEST_LINE} characters;"
                        " export one frame a line"
                    )
                if number > first:
                    yield line.rstrip("\n")

    def head(self, count: int) -> list[str]:
        """Return the first lines, up to one that is too long, which is cut."""
        with self.path.open(encoding=self.encoding, errors="replace") as file:
            pieces = iter(functools.partial(file.readline, _LONGEST_HEAD), "")
            lines = list(itertools.islice(pieces, count))
        long = next((i for i, line in enumerate(lines) if len(line) == _LONGEST_HEAD), count)
        return [line.rstrip("\n") for line in lines[: long + 1]]


@dataclass(frozen=True)
class Grid:
    """Rows of numbers in a text file.

    Attributes:
        file: The file.
        first: Index of the first row's line.
        separator: What is between cells; None for white space.
        width: Number of cells in a row.
        decimal_comma: Whether numbers are written like 1,5.
        ended: Whether a separator ends the rows.
    """

    file: TextFile
    first: int
    separator: str | None
    width: int
    decimal_comma: bool = False
    ended: bool = False

    @classmethod
    def starting(cls, file: TextFile, first: int, *, columns: int = 0) -> Grid:
        """Return the grid whose first row is at a line, detected from that row.

        Args:
            file: The file.
            first: Index of the line.
            columns: Number of coordinates that a row has at least, to distinguish a separator
                that ends the row from an empty cell.
        """
        rows = [_unquoted(row) for row in itertools.islice(file.lines(first), _LOOK)]
        row = rows[0] if rows else ""
        separator = next((s for s in "\t;," if s in row), None)
        if separator is None:
            return cls(file, first, None, len(row.split()))
        cells = [cell.strip() for cell in row.split(separator)]
        comma = separator != "," and any(
            re.fullmatch(r"[-+]?\d*,\d+", cell.strip())
            for row in rows
            for cell in row.split(separator)
        )
        empty = len(cells) - max((i + 1 for i, cell in enumerate(cells) if cell), default=0)
        # A point that was not seen leaves three empty cells: one more ends the row.
        ending = empty % 3 == 1 and len(cells) > columns
        return cls(file, first, separator, len(cells) - ending, comma, ending)

    def blocks(
        self,
        columns: Sequence[int],
        report: ImportReport,
        *,
        counters: int = 0,
        placeholders: bool = False,
    ) -> Iterator[Array]:
        """Iterate over blocks of rows.

        Args:
            columns: Indices of the requested cells of each row.
            report: Gets a warning where rows are left out.
            counters: How many of the columns, the first ones, are no coordinates: numbers of
                frames, or times, which may be written as h:m:s.
            placeholders: Whether coordinates beyond `FARTHEST` that stand there twice are read,
                as numbers that stand for missing ones.

        Yields:
            Numbers, shape (rows, number of `columns`); a missing one is NaN.

        Raises:
            MotionFileError: A row has too few or too many cells, or a requested cell no number;
                names line and column.
        """
        rows = self._rows(report)
        start = self.first
        while lines := list(itertools.islice(rows, _BLOCK)):
            block = self._numbers(lines, start, columns, counters)
            wild = np.abs(block[:, counters:]) > FARTHEST
            if placeholders and wild.any():
                values, counts = np.unique(block[:, counters:], return_counts=True)
                wild &= np.isin(block[:, counters:], values[counts == 1])
            if wild.any():
                row, column = np.argwhere(wild)[0] + [0, counters]
                raise MotionFileError(
                    f"{self.file.path}: line {start + row + 1}, column {columns[column] + 1}:"
                    f" {block[row, column]:g} is not a coordinate; correct that cell, or clear it"
                )
            yield block
            start += len(lines)

    def _rows(self, report: ImportReport) -> Iterator[str]:
        """Iterate over the rows' lines, checked for their number of cells."""
        held: list[str] = []  # a row that may be the last one, and empty ones after it
        index = self.first
        for index, raw in enumerate(self.file.lines(self.first), self.first):
            line = _unquoted(raw)
            if self._is_empty(line):
                held.append(self._checked(line, index))
                continue
            if not line.strip():
                rest = sum(bool(line.strip()) for line in self.file.lines(index))
                if rest:
                    report.warn(
                        f"line {index + 1} is empty; the {rest} lines after it are not read"
                    )
                yield from held[:1]
                return
            yield from held
            held = [self._checked(line, index)]
        if len(held) > 1:
            report.note(f"the last {len(held) - 1} lines have no numbers; they are not used")
        if self.file.ends_whole or len(held) != 1 or not self._may_be_cut(held[0]):
            yield from held[:1]
        else:
            report.warn(
                f"the file ends in line {index + 1} without a line break, perhaps within a number;"
                " that row is not used"
            )

    def _is_empty(self, line: str) -> bool:
        """Return whether a line is a row in which no point was seen."""
        separator = self.separator
        if separator is None or line.strip(f"{separator} "):
            return False
        return line.count(separator) + 1 in (self.width, self.width + 1)

    def _checked(self, line: str, index: int) -> str:
        separator = self.separator
        if self.decimal_comma:
            line = line.replace(",", ".")
        if separator is None:
            cells = len(line.split())
        else:
            cells = line.count(separator) + 1
            ended = (self.ended or cells == self.width + 1) and line.rstrip(" ").endswith(separator)
            if ended:
                line, cells = line.rpartition(separator)[0], cells - 1
        if cells != self.width:
            last = not self.file.ends_whole and next(self.file.lines(index + 1), None) is None
            where = ", where the file ends," if last else ""
            raise MotionFileError(
                f"{self.file.path}: line {index + 1}{where} has {cells} columns, expected"
                f" {self.width}; export the file again, or delete that line"
            )
        if separator and (separator * 2 in line or line[0] == separator or line[-1] == separator):
            return separator.join(cell.strip() or "nan" for cell in line.split(separator))
        return line

    def _may_be_cut(self, line: str) -> bool:
        """Return whether the last row may lack digits: all have as many decimals, or it may."""
        first = itertools.islice(self.file.lines(self.first), _LOOK)
        rows = [self._checked(_unquoted(row), self.first + i) for i, row in enumerate(first)]
        ends = [re.search(r"\.\d+$", row.rstrip()) for row in (*rows, line)]
        decimals = {len(end[0]) if end else 0 for end in ends}
        return len(rows) < 2 or len(decimals) > 1 or 0 in decimals

    def words(self, column: int) -> list[str]:
        """Return the cells of a column, as they are written."""
        rows = self._rows(ImportReport())
        return [row.split(self.separator)[column].strip() for row in rows]

    def _numbers(
        self, lines: list[str], start: int, columns: Sequence[int], counters: int
    ) -> Array:
        try:
            return np.loadtxt(
                lines, delimiter=self.separator, usecols=columns, ndmin=2, comments=None
            )
        except ValueError:
            rows = [
                self._row_numbers(line, start + i, columns, counters)
                for i, line in enumerate(lines)
            ]
            return np.array(rows)

    def _row_numbers(
        self, line: str, index: int, columns: Sequence[int], counters: int
    ) -> list[float]:
        cells = line.split(self.separator)
        numbers = []
        for i, column in enumerate(columns):
            cell = cells[column].strip()
            counts = i < counters
            rate = self._timecode_rates[column] if counts else None
            numbers.append(seconds_of(cell, rate) if counts or is_number(cell) else math.nan)
            other = counts and not self._begins_with_time(column)  # which is not used
            if math.isnan(numbers[-1]) and not (other or is_missing(cell)):
                raise MotionFileError(
                    f"{self.file.path}: line {index + 1}, column {column + 1}:"
                    f" '{cell[:40]}' is not a number; correct that cell, or clear it"
                )
        return numbers

    def _begins_with_time(self, column: int) -> bool:
        """Return whether the first cell of a column is a time or number."""
        return not math.isnan(self._first_times[column])

    @functools.cached_property
    def _timecode_rates(self) -> list[float | None]:
        """Rate of the timecodes in every column, Hz; None where there are none."""
        first = next(self._rows(ImportReport())).split(self.separator)
        return [
            timecode_rate(self.words(column)) if is_timecode(cell.strip()) else None
            for column, cell in enumerate(first)
        ]

    @functools.cached_property
    def _first_times(self) -> list[float]:
        return list(map(seconds_of, next(self._rows(ImportReport())).split(self.separator)))


def _unquoted(line: str) -> str:
    """Return a line without the quotation marks around its cells."""
    return _QUOTED_COMMA.sub(r"\1.\2", line).replace('"', "") if '"' in line else line


def stack(blocks: Iterator[Array], width: int) -> Array:
    """Join blocks of rows without holding them twice.

    Args:
        blocks: Blocks, each shape (rows, width).
        width: Number of columns.

    Returns:
        All rows, shape (T, width).
    """
    rows = np.empty((0, width))
    count = 0
    for block in blocks:
        if count + len(block) > len(rows):
            rows.resize((int(1.2 * count) + len(block), width), refcheck=False)
        rows[count : count + len(block)] = block
        count += len(block)
    rows.resize((count, width), refcheck=False)
    return rows
