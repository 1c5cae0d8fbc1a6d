"""Logs of a robot: commands and measurements as CSV files, from simulation, and their checks."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.errors import RobotLogError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions.readers.cells import is_number
from mpma_mj.motions.readers.text import TextFile
from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.input_files import file_problem

__all__ = ["COLUMNS", "FIRST_ROW", "RobotLog", "check_log", "read_log", "record", "write_log"]

Array = NDArray[np.float64]

_QUANTITIES = ("command", "angle", "velocity")
COLUMNS = ("time", *(f"{what}_{joint}" for what in _QUANTITIES for joint in JOINT_NAMES))
"""Names of the columns."""

FIRST_ROW = 2
"""Line of a file with the first numbers, after the header."""

_HEADER = ", ".join(("time", *(f"{what}_{JOINT_NAMES[0]}" for what in _QUANTITIES), "…"))
_SHOWN = 40  # letters of a cell in a message
_SHORTEST = 5.5  # s (choice)
_LONGEST_PERIOD = 0.1  # s (choice)
_UNEVEN = 0.05  # part of a period that a row may come early or late (choice)
_OFF = 1e-3  # part of a period that may be missing to a whole number of physics steps (choice)
_STILL = 1e-3  # rad/s or rad; less variation is no motion (choice)


@dataclass(frozen=True, eq=False)
class RobotLog:
    """Commands to a robot's arms, and measurements of them.

    Attributes:
        time: Time of each row, shape (T,), s.
        command: Joint velocities commanded from this time on until the next, shape (T, 8), rad/s.
        angle: Joint angles at this time, before the command acts, shape (T, 8), rad.
        velocity: Joint velocities at this time, shape (T, 8), rad/s.
        source: Name for messages.
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


def record(
    env: control.Environment, act: Callable[[Mapping[str, Array]], Array], seconds: float
) -> RobotLog:
    """Return the log of an episode with simulated arms.

    Args:
        env: An environment of `mpma_mj.load`, which is reset; its `latency` and
            `observation_noise` affect the log as they would a robot's.
        act: Returns the action, shape (8,), for an observation.
        seconds: Longest duration, s; the end of the episode ends the log.
    """
    timestep = env.reset()
    period = env.control_timestep()
    rows: list[tuple[Array, Array, Array]] = []
    while not timestep.last() and len(rows) < round(seconds / period):
        observation = timestep.observation
        action = act(observation)
        command = clip(action) * env.task.max_joint_speed
        rows.append((command, observation["joint_angles"], observation["joint_velocities"]))
        timestep = env.step(action)
    command, angle, velocity = map(np.array, zip(*rows, strict=True))
    return RobotLog(np.arange(len(rows)) * period, command, angle, velocity)


def write_log(path: str | Path, log: RobotLog) -> None:
    """Write a log to a CSV file."""
    table = np.column_stack([log.time, log.command, log.angle, log.velocity])
    with (
        atomic_write(Path(path)) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(table.tolist())


def read_log(path: str | Path) -> RobotLog:
    """Read a log; `check_log` checks whether it fits the arms' model.

    Args:
        path: CSV file with the columns `COLUMNS` in any order; others are ignored.

    Raises:
        RobotLogError: The file does not exist, is no table, lacks columns, or has a cell that is
            no finite number; names row and column.
    """
    path = Path(path)
    if problem := file_problem(path):
        raise RobotLogError(f"{path}: {problem}; a robot's log is CSV with the header {_HEADER}")
    file = TextFile.open(path)
    if file is None:
        raise RobotLogError(f"{path}: is not a text file; expected CSV with the header {_HEADER}")
    head = next(file.lines(), "")
    titles = [cell.strip() for cell in head.replace('"', "").split(",")]
    missing = [column for column in COLUMNS if column not in titles]
    if len(missing) == len(COLUMNS):
        raise RobotLogError(
            f"{path}: is not a robot's log; expected a first row with the columns {_HEADER},"
            " separated by commas"
        )
    if missing:
        raise RobotLogError(
            f"{path}: lacks {', '.join(missing)}; add these columns, or rename yours"
        )
    twice = next((column for column in COLUMNS if titles.count(column) > 1), None)
    if twice:
        raise RobotLogError(f"{path}: has column {twice} twice; rename or remove one")
    table = _numbers(file, titles)
    command, angle, velocity = np.split(table[:, 1:], len(_QUANTITIES), axis=1)
    return RobotLog(table[:, 0], command, angle, velocity, str(path))


def _numbers(file: TextFile, titles: list[str]) -> Array:
    """Return the numbers of all rows, shape (T, 25), columns as in `COLUMNS`."""
    columns = [titles.index(column) for column in COLUMNS]
    lines = list(file.lines(1))
    while lines and not lines[-1].strip():
        lines.pop()
    if not lines:
        raise RobotLogError(f"{file.path}: has a header but no rows; expected a row for each time")
    table = np.empty((len(lines), len(COLUMNS)))
    for row, line in enumerate(lines):
        cells = line.replace('"', "").split(",")
        number = row + FIRST_ROW
        if len(cells) != len(titles):
            raise RobotLogError(
                f"{file.path}: row {number} has {len(cells)} cells, but the header has"
                f" {len(titles)}; correct or delete that row: {line[:_SHOWN]}"
            )
        for column, place in enumerate(columns):
            cell = cells[place]
            if not is_number(cell) or not math.isfinite(float(cell)):
                raise RobotLogError(
                    f"{file.path}: row {number}, column {COLUMNS[column]}:"
                    f" '{cell[:_SHOWN]}' is not a finite number; correct that cell"
                )
            table[row, column] = float(cell)
    return table


def check_log(log: RobotLog, model: mujoco.MjModel) -> int:
    """Return the physics steps from row to row of a log that fits the arms' model.

    Raises:
        RobotLogError: Times are uneven, too few or too far apart, commands exceed the model's
            bounds, or nothing moves; names row and column.
    """

    def row(index: int) -> str:
        return f"{log.source}: row {index + FIRST_ROW}"

    elapsed = np.diff(log.time)
    usual = float(np.median(elapsed))
    length = float(log.time[-1] - log.time[0])
    for i in np.flatnonzero(elapsed <= 0.0)[:1] + 1:
        raise RobotLogError(
            f"{row(i)}: time is {log.time[i]:g} s after {log.time[i - 1]:g} s; expected ascending"
            " times; sort the rows, or remove that one"
        )
    if length < _SHORTEST:
        raise RobotLogError(
            f"{log.source}: is {length:.3g} s long; expected at least {_SHORTEST:g} s, better a"
            " minute; check that times are in seconds"
        )
    for i in np.flatnonzero(np.abs(elapsed - usual) > _UNEVEN * usual)[:1] + 1:
        raise RobotLogError(
            f"{row(i)} comes {elapsed[i - 1]:.4g} s after the one before; expected {usual:.4g} s ±"
            f" {100 * _UNEVEN:g} %; add the missing rows, or cut the log there"
        )
    if log.period > _LONGEST_PERIOD:
        raise RobotLogError(
            f"{log.source}: has a row every {log.period:.3g} s; expected at most"
            f" {_LONGEST_PERIOD:g} s; record it at a higher rate"
        )
    timestep = 1000.0 * float(model.opt.timestep)  # ms
    exact = 1000.0 * log.period / timestep
    steps = round(exact)
    if steps < 1 or abs(exact - steps) > _OFF * steps:
        fewer = max(1, int(exact))
        raise RobotLogError(
            f"{log.source}: has a row every {1000.0 * log.period:.5g} ms; expected a whole number"
            f" of physics steps of {timestep:g} ms, such as {fewer * timestep:g} or"
            f" {(fewer + 1) * timestep:g} ms",
            remedy="record it so, or give a {robot} with another timestep",
        )
    most = np.array([model.actuator(name).ctrlrange[1] for name in JOINT_NAMES])
    for i, joint in np.argwhere(np.abs(log.command) > most * (1.0 + 1e-9))[:1]:
        raise RobotLogError(
            f"{row(i)}, column command_{JOINT_NAMES[joint]}: {log.command[i, joint]:g} rad/s, but"
            f" the model takes {most[joint]:g} at most",
            remedy="check the unit, or give a {robot} with a wider ctrlrange",
        )
    if np.ptp(log.command, axis=0).max() < _STILL:
        raise RobotLogError(
            f"{log.source}: no command ever changes; expected commands that move all joints, now"
            " fast, now slowly"
        )
    if np.ptp(log.angle, axis=0).max() < _STILL:
        raise RobotLogError(
            f"{log.source}: no angle ever changes, whatever is commanded; check the brakes, and"
            " the order of the columns"
        )
    turns = np.diff(log.angle, axis=0)
    expected = 0.5 * (log.velocity[1:] + log.velocity[:-1]) * elapsed[:, None]
    for i, joint in np.argwhere(np.abs(turns - expected) > np.pi)[:1]:
        raise RobotLogError(
            f"{row(i + 1)}, column angle_{JOINT_NAMES[joint]}: jumps by {turns[i, joint]:.3g},"
            " which its velocity does not explain; expected rad without steps of 2π; unwrap the"
            " angles, or check their unit"
        )
    return steps
