"""Reader for the text export (TSV) of Qualisys Track Manager, the paper's recording system.

A file is a header of `KEY<tab>value` lines up to MARKER_NAMES, perhaps a line of column
titles, then a row of x, y, z for every marker a frame, in millimetres, z up. Some exports put
the frame number, or frame number and time, before the first marker. A marker that was not seen
is an empty cell, NaN, or exactly 0, 0, 0.
"""

from __future__ import annotations

import contextlib
import statistics
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError

__all__ = ["MarkerRecording", "arm_points", "is_qualisys", "read_qualisys"]

Array = NDArray[np.float64]

# For each point the groups of markers whose mean it is, the first that is there; {s} is the side.
_MARKERS = {
    "shoulder": (("Shoulder_{s}",),),
    "elbow": (("Elbow_{s}",),),
    "wrist": (("Radius_{s}", "Ulna_{s}"), ("Wrist_{s}",)),
}
_SIDE_LETTER = {"left": "L", "right": "R"}

_FARTHEST = 1e9  # what is farther away, in any unit, is no coordinate


@dataclass(frozen=True, eq=False)
class MarkerRecording:
    """Marker trajectories as a file has them.

    Attributes:
        markers: Trajectories by marker name, each shape (T, 3), z up; not seen is NaN.
        rate: Frames per second, Hz.
    """

    markers: dict[str, Array]
    rate: float


def is_qualisys(text: str) -> bool:
    """Tell whether a text is a Qualisys export, by its content."""
    return "MARKER_NAMES" in text[:4096] or text.startswith("NO_OF_FRAMES")


def read_qualisys(path: Path, text: str) -> MarkerRecording:
    """Read the markers of a Qualisys export.

    Args:
        path: The file, for messages.
        text: What stands in it.

    Returns:
        The recording.

    Raises:
        MotionFileError: The header is incomplete, or a row or a cell is not as the header
            says; names the line and the column.
    """
    lines = text.splitlines()
    header, names, first = _read_header(path, lines)
    rate = _read_rate(path, header)
    table = _read_table(path, lines, first, 3 * len(names))
    tracks = table.reshape(len(table), len(names), 3)
    tracks[(tracks == 0.0).all(axis=2)] = np.nan
    return MarkerRecording({name: tracks[:, i] for i, name in enumerate(names)}, rate)


def arm_points(path: Path, markers: dict[str, Array]) -> dict[str, tuple[str, ...]]:
    """Find, by name, which markers show the arms.

    Args:
        path: The file, for messages.
        markers: Trajectories by marker name.

    Returns:
        For each point of `body.ARM_POINTS` the markers whose mean it is.

    Raises:
        MotionFileError: A marker is missing; says which, and which the file has.
    """
    points = {}
    for side, letter in _SIDE_LETTER.items():
        for point, choices in _MARKERS.items():
            groups = [tuple(name.format(s=letter) for name in group) for group in choices]
            there = [group for group in groups if all(name in markers for name in group)]
            if not there:
                wanted = ", or ".join(" and ".join(group) for group in groups)
                raise MotionFileError(
                    f"{path}: no marker {wanted}; the {side} {point} needs it, and the file has"
                    f" {', '.join(markers)}: rename the marker, or export with it"
                )
            points[f"{side}_{point}"] = there[0]
    return points


def _read_header(path: Path, lines: list[str]) -> tuple[dict[str, str], list[str], int]:
    """Return header values, marker names, and the index of the first line of numbers."""
    header: dict[str, str] = {}
    for index, line in enumerate(lines):
        key, _, value = line.partition("\t")
        header[key.strip()] = value.strip()
        if key.strip() == "MARKER_NAMES":
            names = [name.strip() for name in value.strip().split("\t")]
            if not all(names):
                raise MotionFileError(f"{path}: line {index + 1}: MARKER_NAMES lacks a name")
            if len(set(names)) < len(names):
                twice = next(n for n in names if names.count(n) > 1)
                raise MotionFileError(
                    f"{path}: line {index + 1}: marker {twice} stands twice; names must differ"
                )
            # Column titles and the like may follow; a row of the table has a number in it.
            numbers = (i for i in range(index + 1, len(lines)) if _has_number(lines[i]))
            return header, names, next(numbers, len(lines))
    raise MotionFileError(f"{path}: no line MARKER_NAMES; expected a Qualisys TSV export")


def _read_rate(path: Path, header: dict[str, str]) -> float:
    value = header.get("FREQUENCY", "")
    try:
        rate = float(value)
    except ValueError:
        rate = float("nan")
    if not (np.isfinite(rate) and rate > 0):
        raise MotionFileError(
            f"{path}: FREQUENCY is '{value}'; expected the frames per second, a number above 0"
        )
    return rate


def _read_table(path: Path, lines: list[str], first: int, columns: int) -> Array:
    """Return the coordinates, shape (T, columns), without frame number and time."""
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    rows = {number: _cells(line) for number, line in enumerate(lines[first:], first + 1)}
    if not rows:
        raise MotionFileError(f"{path}: has a header but no frames; export the 3D data too")
    usual = statistics.mode(len(cells) for cells in rows.values())
    extra = usual - columns if usual - columns in (0, 1, 2) else 0  # frame number, time
    for number, cells in rows.items():
        if len(cells) != columns + extra:
            raise MotionFileError(
                f"{path}: line {number} has {len(cells)} columns, expected {columns + extra}:"
                f" x, y, z for each of {columns // 3} markers; export the file anew"
            )
    try:
        table = np.array([[cell or "nan" for cell in row] for row in rows.values()], np.float64)
    except ValueError:
        raise MotionFileError(f"{path}: {_first_text(rows)}") from None
    wild = np.abs(table) > _FARTHEST
    if wild.any():
        row, column = np.argwhere(wild)[0]
        raise MotionFileError(
            f"{path}: line {first + 1 + row}, column {column + 1}: {table[row, column]:g} is no"
            " coordinate; mend that cell, or empty it"
        )
    return table[:, extra:]


def _has_number(line: str) -> bool:
    for cell in line.split("\t"):
        with contextlib.suppress(ValueError):
            float(cell)
            return True
    return False


def _cells(line: str) -> list[str]:
    """Split a row; a tab that ends it does not begin another cell."""
    cells = [cell.strip() for cell in line.split("\t")]
    empty = len(cells) - max((i + 1 for i, cell in enumerate(cells) if cell), default=0)
    # A marker that was not seen leaves three empty cells, so that one more is the ending tab.
    return cells[:-1] if empty % 3 == 1 else cells


def _first_text(rows: dict[int, list[str]]) -> str:
    """Say where the first cell stands that is not a number."""
    for number, row in rows.items():
        for column, cell in enumerate(row, start=1):
            try:
                float(cell or "nan")
            except ValueError:
                return f"line {number}, column {column}: '{cell}' is not a number; mend that cell"
    raise AssertionError("called for a table without text")
