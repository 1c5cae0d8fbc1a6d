"""Cells of tables: numbers, times of day, and words that stand for a missing value."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable

__all__ = ["is_missing", "is_number", "is_timecode", "positive", "seconds_of", "timecode_rate"]

# As spreadsheets, C of different makers, databases and statistics programs write it.
_MISSING = re.compile(
    r"|[-+]?[qs]?nan(\(\w*\))?|[-+]?1\.#\w*|[-+]?inf(inity)?|#?n[/.]?a[.]?|#(value|num|ref|null)!"
    r"|#div/0!|#name\?|null|none|nil|missing|\\n|[-.?*]+",
    re.IGNORECASE,
)
_TIME_OF_DAY = re.compile(r"(?<![\d:])(?:(\d+):)?(\d+):(\d\d(?:[.,]\d+)?)(?![\d:;])")
_TIMECODE = re.compile(r"(?P<time>\d+:\d\d:\d\d):(?P<frames>\d\d\d?)")
_TIMECODES = (24, 25, 30, 48, 50, 60, 100, 120)  # Hz that timecodes have


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


def is_timecode(cell: str) -> bool:
    """Return whether a cell holds h:m:s:frames."""
    return _TIMECODE.fullmatch(cell) is not None


def timecode_rate(cells: Iterable[str]) -> float | None:
    """Return the rate of timecodes h:m:s:frames, Hz, if a second ends and shows it.

    Args:
        cells: Those of all rows.
    """
    found = [match for match in map(_TIMECODE.fullmatch, cells) if match]
    frames = [int(match["frames"]) for match in found]
    last = max((a for a, b in itertools.pairwise(frames) if b < a), default=-1)
    return float(last + 1) if last + 1 in _TIMECODES and last == max(frames) else None


def seconds_of(cell: str, rate: float | None = None) -> float:
    """Return the time in a cell, s: a number, or h:m:s after midnight whatever the date is.

    NaN for what is neither, and for timecodes h:m:s:frames without their rate.

    Args:
        cell: The cell.
        rate: Rate of timecodes, Hz.
    """
    if is_number(cell):
        return float(cell)
    timecode = _TIMECODE.fullmatch(cell)
    if timecode and rate:
        return seconds_of(timecode["time"]) + int(timecode["frames"]) / rate
    found = _TIME_OF_DAY.search(cell)
    if found is None:
        return math.nan
    hours, minutes, seconds = found.groups()
    return 3600.0 * float(hours or 0) + 60.0 * float(minutes) + float(seconds.replace(",", "."))
