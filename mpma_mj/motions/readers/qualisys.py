"""Reader for the text export (TSV) of Qualisys Track Manager, the paper's recording system.

A file is a header of `KEY<tab>value` lines up to MARKER_NAMES, perhaps lines of column titles,
then a row of x, y, z for every marker a frame, in millimetres, z up. Some exports put the frame
number, or frame number and time, before the first marker.
"""

from __future__ import annotations

import numpy as np

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import is_number, positive
from mpma_mj.motions.readers.recording import UNITS, Recording
from mpma_mj.motions.readers.tables.columns import load_columns, neighbours
from mpma_mj.motions.readers.text import Grid, TextFile

__all__ = ["is_qualisys", "read_qualisys"]

_LONGEST_HEADER = 60  # lines


def is_qualisys(head: list[str]) -> bool:
    """Return whether the first lines are those of a Qualisys export."""
    return any(line.split("\t")[0].strip() in ("NO_OF_FRAMES", "MARKER_NAMES") for line in head)


def read_qualisys(file: TextFile, report: ImportReport) -> Recording:
    """Read the header of a Qualisys export.

    Raises:
        MotionFileError: The header is incomplete.
    """
    path = file.path
    header: dict[str, str] = {}
    lines = file.head(_LONGEST_HEADER)
    first = 0
    while first < len(lines) and "MARKER_NAMES" not in header:
        key, _, value = lines[first].partition("\t")
        header[key.strip()] = value.strip()
        first += 1
    included = header.get("DATA_INCLUDED", "3D")
    if "MARKER_NAMES" not in header and included != "3D":
        raise MotionFileError(
            f"{path}: holds {included[:40]}, such as rotations of bodies, and no"
            " markers; export the 3D data"
        )
    if "MARKER_NAMES" not in header:
        raise MotionFileError(f"{path}: no line MARKER_NAMES; export the file with its header")
    names = [name.strip() for name in header["MARKER_NAMES"].split("\t")]
    if not all(names):
        raise MotionFileError(f"{path}: line {first}: MARKER_NAMES lacks a name")
    # Column titles and the like may follow; a row of the table has a number in it.
    while first < len(lines) and not _has_number(lines[first]):
        first += 1
    grid = Grid.starting(file, first, columns=3 * len(names))
    extra = grid.width - 3 * len(names)  # frame number, time
    if first < len(lines) and extra not in (0, 1, 2):
        raise MotionFileError(
            f"{path}: line {first + 1} has {grid.width} columns, expected {3 * len(names)}: x, y,"
            f" z for each of {len(names)} markers; export the file again"
        )
    columns = {name: extra + 3 * i for i, name in reversed([*enumerate(names)])}
    counted = 0 if extra > 0 and _counts(grid) else None
    return Recording(
        path,
        "Qualisys TSV",
        tuple(names),
        lambda names: load_columns(grid, neighbours(columns), names, report, frame_column=counted),
        rate=_number(path, header, "FREQUENCY"),
        unit=UNITS["mm"],
        up="z",
        frames=int(_number(path, header, "NO_OF_FRAMES") or 0) or None,
    )


def _has_number(line: str) -> bool:
    return any(is_number(cell.replace(",", ".")) for cell in line.split("\t"))


def _counts(grid: Grid) -> bool:
    """Return whether the first column has whole numbers: the frame's, where time has none."""
    column = next(grid.blocks([0], ImportReport()), np.empty((0, 1)))
    return bool((column == np.round(column)).all())


def _number(path: object, header: dict[str, str], key: str) -> float | None:
    """Return a number of the header, if it is there."""
    value = header.get(key)
    if value is None:
        return None
    number = positive(value)
    if number is None:
        raise MotionFileError(f"{path}: {key} is '{value}'; expected a number above 0")
    return number
