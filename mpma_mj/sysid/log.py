"""Logs of commands and of what arms did: a table with a header."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import RobotLogError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions.readers.text import TextFile, is_number, printable
from mpma_mj.utils.atomic_files import atomic_write

__all__ = ["COLUMNS", "FIRST_ROW", "RobotLog", "read_log", "write_log"]

Array = NDArray[np.float64]

_QUANTITIES = ("command", "angle", "velocity")
COLUMNS = ("time", *(f"{what}_{joint}" for what in _QUANTITIES for joint in JOINT_NAMES))
"""Names of the columns."""

FIRST_ROW = 2
"""Line of a file in which the first numbers stand, after the header."""

_SHOWN = 40  # letters of a cell in a message


@dataclass(frozen=True, eq=False)
class RobotLog:
    """What was commanded, and what arms did.

    Attributes:
        time: Time of each row, shape (T,), s.
        command: Joint velocities commanded from this time on until the next, shape (T, 8), rad/s.
        angle: Joint angles at this time, before the command acts, shape (T, 8), rad.
        velocity: Joint velocities at this time, shape (T, 8), rad/s.
        source: Where it comes from, for messages.
    """

    time: Array
    command: Array
    angle: Array
    velocity: Array
    source: str = "log"

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.time)

    @property
    def period(self) -> float:
        """Mean time from row to row, s."""
        return float((self.time[-1] - self.time[0]) / (len(self) - 1))


def read_log(path: str | Path) -> RobotLog:
    """Read a log; whether it is fit for the arms' model, `check_log` says.

    Args:
        path: The CSV file, with the columns `COLUMNS` in any order; others are left out.

    Raises:
        RobotLogError: There is no such file, it is no table, columns are missing, or a cell is no
            finite number; names row and column.
    """
    path = Path(path)
    if not path.is_file():
        found = "this is a folder" if path.is_dir() else "there is none"
        raise RobotLogError(f"{path}: expected a CSV file of a robot's log, and {found}")
    file = TextFile.open(path)
    if file is None:
        raise RobotLogError(f"{path}: is no text; expected a CSV file, its header {_header()}")
    head = next(file.lines(), "")
    titles = [cell.strip() for cell in head.replace('"', "").split(",")]
    missing = [column for column in COLUMNS if column not in titles]
    if len(missing) == len(COLUMNS):
        raise RobotLogError(
            f"{path}: is no log of a robot; expected a first row with the columns {_header()},"
            " a comma between them"
        )
    if missing:
        raise RobotLogError(f"{path}: lacks {', '.join(missing)}; name the columns so, or add them")
    twice = next((column for column in COLUMNS if titles.count(column) > 1), None)
    if twice:
        raise RobotLogError(f"{path}: has {twice} twice; rename or remove one")
    table = _numbers(file, titles)
    command, angle, velocity = np.split(table[:, 1:], len(_QUANTITIES), axis=1)
    return RobotLog(table[:, 0], command, angle, velocity, str(path))


def write_log(path: str | Path, log: RobotLog) -> None:
    """Write a log.

    Args:
        path: The CSV file.
        log: The log.
    """
    table = np.column_stack([log.time, log.command, log.angle, log.velocity])
    with (
        atomic_write(Path(path)) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(table.tolist())


def _header() -> str:
    return ", ".join(("time", *(f"{what}_{JOINT_NAMES[0]}" for what in _QUANTITIES), "…"))


def _numbers(file: TextFile, titles: list[str]) -> Array:
    """Return the numbers of all rows, shape (T, 25), columns as in `COLUMNS`."""
    columns = [titles.index(column) for column in COLUMNS]
    lines = list(file.lines(1))
    while lines and not lines[-1].strip():
        lines.pop()
    if not lines:
        raise RobotLogError(f"{file.path}: has a header and no rows; expected a row each time")
    table = np.empty((len(lines), len(COLUMNS)))
    for row, line in enumerate(lines):
        cells = line.replace('"', "").split(",")
        number = row + FIRST_ROW
        if len(cells) != len(titles):
            raise RobotLogError(
                f"{file.path}: row {number} has {len(cells)} cells, but the header {len(titles)};"
                f" mend or delete that row: {printable(line[:_SHOWN])}"
            )
        for column, place in enumerate(columns):
            cell = cells[place]
            if not is_number(cell) or not math.isfinite(float(cell)):
                raise RobotLogError(
                    f"{file.path}: row {number}, column {COLUMNS[column]}:"
                    f" '{printable(cell[:_SHOWN])}'; expected a finite number, so mend that cell"
                )
            table[row, column] = float(cell)
    return table
