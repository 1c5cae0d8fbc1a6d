"""Reader for TRC, the track row column format of Motion Analysis, which OpenSim uses.

Line 1 names the file, line 2 the values that line 3 gives (DataRate, NumFrames, Units, …),
line 4 the markers above their three columns, line 5 those columns (X1, Y1, Z1, …). Frame number
and time begin every row. Cells are separated by tabs, in some exports by commas.
"""

from __future__ import annotations

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.columns import load_columns, neighbours, rate_of_times
from mpma_mj.motions.readers.recording import UNITS, Recording
from mpma_mj.motions.readers.text import Grid, TextFile, positive

__all__ = ["is_trc", "read_trc"]

_HEADER = 5  # lines before the first row, which an empty line may follow


def is_trc(head: list[str]) -> bool:
    """Return whether the first lines are those of a TRC."""
    return bool(head) and head[0].startswith("PathFileType")


def read_trc(file: TextFile, report: ImportReport) -> Recording:
    """Read the header of a TRC.

    Raises:
        MotionFileError: The header is incomplete.
    """
    path = file.path
    lines = file.head(_HEADER + 5)
    if len(lines) < _HEADER:
        raise MotionFileError(
            f"{path}: ends after {len(lines)} lines, within the header; export the file again"
        )
    separator = "\t" if "\t" in lines[1] else ","
    keys, values, titles = ([c.strip() for c in row.split(separator)] for row in lines[1:4])
    header = dict(zip(keys, values, strict=False))
    columns: dict[str, int] = {}
    names = [name for name in titles[2:] if name]
    for column, name in enumerate(titles[2:], start=2):
        if name:
            columns.setdefault(name, column)
    first = next(
        (i for i in range(_HEADER, len(lines)) if lines[i].strip(f" {separator}")), len(lines)
    )
    grid = Grid.starting(file, first, columns=2 + 3 * len(names))
    rate, frames = (positive(header.get(key, "")) for key in ("DataRate", "NumFrames"))
    if first < len(lines):
        if grid.width < max(columns.values(), default=0) + 3:
            raise MotionFileError(
                f"{path}: line {first + 1} has {grid.width} columns, fewer than x, y, z for each"
                f" of {len(names)} markers; export the file again"
            )
        rate = rate_of_times(grid, 1, rate, report)
    return Recording(
        path,
        "TRC",
        tuple(names),
        lambda names: load_columns(
            grid, neighbours(columns), names, report, frame_column=0, time_column=1
        ),
        rate=rate,
        unit=UNITS.get(header.get("Units", "").lower()),
        frames=int(frames) if frames else None,
    )
