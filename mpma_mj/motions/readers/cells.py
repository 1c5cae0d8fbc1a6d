"""Cells of tables: numbers, times of day, and words that stand for a missing value."""

from __future__ import annotations

import math
import re

__all__ = ["is_missing", "is_number", "positive", "seconds_of"]

# As spreadsheets, C of different makers, databases and statistics programs write it.
_MISSING = re.compile(
    r"|[-+]?[qs]?nan(\(\w*\))?|[-+]?1\.#\w*|[-+]?inf(inity)?|#?n[/.]?a[.]?|#(value|num|ref|null)!"
    r"|#div/0!|#name\?|null|none|nil|missing|\\n|[-.?*]+",
    re.IGNORECASE,
)
_TIME_OF_DAY = re.compile(r"(?<![\d:])(?:(\d+):)?(\d+):(\d\d(?:[.,]\d+)?)(?![\d:;])")


def is_number(cell: str) -> bool:
    """Return whether a cell holds a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # which Python allows between digits, and no file means


def is_missing(cell: str) -> bool:
    """Return whether a cell stands for a missing value."""
    return _MISSING.fullmatch(cell.strip()) is not None


def positive(cell: str) -> float | None:
    """Return the number above 0 in a cell, if there is one."""
    number = float(cell) if is_number(cell) else 0.0
    return number if 0.0 < number < math.inf else None


def seconds_of(cell: str) -> float:
    """Return the time in a cell, s: a number, or h:m:s after midnight whatever the date is.

    NaN for what is neither, such as h:m:s:frames, which depends on the rate.
    """
    if is_number(cell):
        return float(cell)
    found = _TIME_OF_DAY.search(cell)
    if found is None:
        return math.nan
    hours, minutes, seconds = found.groups()
    return 3600.0 * float(hours or 0) + 60.0 * float(minutes) + float(seconds.replace(",", "."))
