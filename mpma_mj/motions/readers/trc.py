"""Reader for TRC, the track row column format of Motion Analysis, which OpenSim uses.

Line 1 names the file, line 2 the values that line 3 gives (DataRate, NumFrames, Units, …),
line 4 the markers above their three columns, line 5 those columns (X1, Y1, Z1, …). Frame number
and time begin every row. Cells are separated by tabs, in some exports by commas.
"""

from __future__ import annotations

import re
from pathlib import Path

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.cells import positive
from mpma_mj.motions.readers.recording import Recording
from mpma_mj.motions.readers.tables.columns import load_columns, neighbours, rate_of_times
from mpma_mj.motions.readers.tables.titles import length_unit
from mpma_mj.motions.readers.text import Grid, TextFile

__all__ = ["is_trc", "read_trc"]

_HEADER = 5  # lines before the first row, which an empty line may follow


def is_trc(head: list[str]) -> bool:
    """Return whether the first lines are those of a TRC."""
    return bool(head) and head[0].lower().startswith("pathfiletype")


def read_trc(file: TextFile, report: ImportReport) -> Recording:
    """Read the header of a TRC.

    Raises:
        MotionFileError: The header is incomplete, or contradicts the rows.
    """
    path = file.path
    lines = file.head(_HEADER + 5)
    if len(lines) < _HEADER:
        raise MotionFileError(
            f"{path}: ends after {len(lines)} lines, within the header; export the file again"
        )
    separator = next((s for s in "\t," if s in lines[1]), None)
    keys, values, titles, axes = ([c.strip() for c in row.split(separator)] for row in lines[1:5])
    header = {key.lower(): value for key, value in zip(keys, values, strict=False)}
    named = [(column, name) for column, name in enumerate(titles[2:], start=2) if name]
    blank = f"{separator or ''} "
    first = next((i for i in range(_HEADER, len(lines)) if lines[i].strip(blank)), len(lines))
    grid = Grid.starting(file, first, columns=2 + 3 * len(named))
    rate, frames, markers = (
        _number(header.get(key, "")) for key in ("datarate", "numframes", "nummarkers")
    )
    if first < len(lines):
        named = _columns(path, named, grid.width, axes, markers)
        rate = rate_of_times(grid, 1, rate, report)
    columns = {name: column for column, name in reversed(named)}
    return Recording(
        path,
        "TRC",
        tuple(name for _, name in named),
        lambda names: load_columns(
            grid, neighbours(columns), names, report, frame_column=0, time_column=1
        ),
        rate=rate,
        unit=length_unit(header.get("units", "")),
        frames=int(frames) if frames else None,
    )


def _columns(
    path: Path, named: list[tuple[int, str]], width: int, axes: list[str], markers: float | None
) -> list[tuple[int, str]]:
    """Return the column of x of each marker, with its name.

    A name stands above its x, and in some exports one or two tabs after the one before it; then
    the count of markers, the axes and the columns have to agree on which is whose.
    """
    if all((column - 2) % 3 == 0 and column + 3 <= width for column, _ in named):
        return named
    counts = {
        "names": len(named),
        "markers by NumMarkers": markers,
        "titles X": sum(cell[:1] in ("X", "x") for cell in axes) or None,
        "columns in threes after Frame# and Time": (width - 2) / 3,
    }
    if len(set(counts.values()) - {None}) > 1:
        has = ", ".join(f"{n:.4g} {what}" for what, n in counts.items() if n is not None)
        raise MotionFileError(
            f"{path}: the names do not stand above x of x, y, z, and the header and its rows"
            f" contradict each other: {has}; export the file again"
        )
    return [(2 + 3 * i, name) for i, (_, name) in enumerate(named)]


def _number(cell: str) -> float | None:
    """Return the number above 0 in a cell, which may have a unit and a decimal comma."""
    found = re.fullmatch(r"([\d.,e+-]+)\s*(hz|fps)?", cell, re.IGNORECASE)
    return positive(found[1].replace(",", ".")) if found else None
