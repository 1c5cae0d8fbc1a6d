"""Labels that a user wrote: a CSV of start, end and label."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from mpma_mj.context import Span
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers.text import TextFile, is_number

__all__ = ["read_labels"]


def read_labels(path: Path) -> tuple[Span, ...]:
    """Read rows of `start,end,label`, in seconds from the recording's first frame.

    A first row that is no numbers is a header. Spans may overlap; a comma, a semicolon or a tab
    is between cells.

    Raises:
        MotionFileError: The file cannot be read, or a row is not as it should be; names the
            line.
    """
    try:
        file = TextFile.open(path)
    except OSError as error:
        raise MotionFileError(f"{path}: cannot be read ({error.strerror})") from None
    if file is None:
        raise MotionFileError(f"{path}: is no text; expected rows of start,end,label in seconds")
    spans = []
    for number, line in enumerate(file.lines(), 1):
        cells = _cells(line)
        numbers = [is_number(cell) for cell in cells[:2]]
        if not any(cells) or (number == 1 and not any(numbers)):
            continue
        if len(cells) != 3 or not all(numbers) or not cells[2]:
            raise MotionFileError(
                f"{path}: line {number}: '{line[:60]}' is not start,end,label, such as 0,2.5,Y"
            )
        start, end = map(float, cells[:2])
        if not (math.isfinite(start) and start < end):
            raise MotionFileError(
                f"{path}: line {number}: the span from {start:g} to {end:g} s has no length;"
                " expected an end after its start"
            )
        spans.append(Span(start, end, cells[2]))
    if not spans:
        raise MotionFileError(f"{path}: holds no rows of start,end,label")
    return tuple(spans)


def _cells(line: str) -> list[str]:
    """Return the cells of a row, with points for decimal commas, by the separator that fits."""
    found = [line]
    for separator in ",;\t":
        try:
            cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
        except csv.Error:  # such as a cell of more than 131072 letters
            continue
        cells[:2] = [cell.replace(",", ".") for cell in cells[:2]]
        if len(cells) == 3 and all(map(is_number, cells[:2])):
            return cells
        if len(cells) > 1:
            found = cells
    return found
