"""Whether a log is one from which the arms' parameters can be found."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import RobotLogError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.sysid.log import FIRST_ROW, RobotLog

__all__ = ["check_log"]

Array = NDArray[np.float64]

_SHORTEST = 5.5  # s; windows of the fit then outnumber the parameters (choice)
_LONGEST_PERIOD = 0.1  # s; as above (choice)
_UNEVEN = 0.05  # part of a period that a row may come early or late (choice)
_OFF = 1e-3  # part of a period that may be missing to a whole number of physics steps (choice)
_STILL = 1e-3  # rad/s or rad; what varies by less does not move (choice)


def check_log(log: RobotLog, model: mujoco.MjModel) -> int:
    """Check that a log shows how arms answer to commands.

    Args:
        log: The log.
        model: The arms that are to do the same.

    Returns:
        Physics steps from row to row.

    Raises:
        RobotLogError: It does not; says in which row or column, and what was expected.
    """
    _check_times(log)
    steps = _physics_steps(log, float(model.opt.timestep))
    _check_commands(log, model)
    _check_angles(log)
    return steps


def _check_times(log: RobotLog) -> None:
    length = float(log.time[-1] - log.time[0])
    steps = np.diff(log.time)
    falling = np.flatnonzero(steps <= 0.0)
    if len(falling):
        row = int(falling[0])
        raise RobotLogError(
            f"{log.source}: row {row + 1 + FIRST_ROW}: time is {log.time[row + 1]:g} s after"
            f" {log.time[row]:g} s; expected times that ascend, so sort the rows, or remove that"
            " one"
        )
    if length < _SHORTEST:
        raise RobotLogError(
            f"{log.source}: is {length:.3g} s long; expected at least {_SHORTEST:g} s, better a"
            " minute, in seconds"
        )
    usual = float(np.median(steps))
    uneven = np.flatnonzero(np.abs(steps - usual) > _UNEVEN * usual)
    if len(uneven):
        row = int(uneven[0])
        raise RobotLogError(
            f"{log.source}: row {row + 1 + FIRST_ROW} comes {steps[row]:.4g} s after the one"
            f" before; expected {usual:.4g} s ± {100 * _UNEVEN:g} %, so fill in what is missing, or"
            " cut the log there"
        )
    if log.period > _LONGEST_PERIOD:
        raise RobotLogError(
            f"{log.source}: has a row every {log.period:.3g} s; expected at most"
            f" {_LONGEST_PERIOD:g} s, so record it faster"
        )


def _physics_steps(log: RobotLog, timestep: float) -> int:
    exact = log.period / timestep
    steps = round(exact)
    if steps < 1 or abs(exact - steps) > _OFF * steps:
        fewer = max(1, int(exact))
        raise RobotLogError(
            f"{log.source}: has a row every {1000 * log.period:.5g} ms; expected a whole number of"
            f" physics steps of {1000 * timestep:g} ms, such as {1000 * fewer * timestep:g} or"
            f" {1000 * (fewer + 1) * timestep:g} ms",
            remedy="record it so, or give a {model} with another timestep",
        )
    return steps


def _check_commands(log: RobotLog, model: mujoco.MjModel) -> None:
    most = np.array([model.actuator(name).ctrlrange[1] for name in JOINT_NAMES])
    beyond = np.argwhere(np.abs(log.command) > most * (1.0 + 1e-9))
    if len(beyond):
        row, joint = map(int, beyond[0])
        raise RobotLogError(
            f"{log.source}: row {row + FIRST_ROW}, column command_{JOINT_NAMES[joint]}:"
            f" {log.command[row, joint]:g} rad/s, but the model takes {most[joint]:g} at most",
            remedy="check the unit, or give a {model} with a wider ctrlrange",
        )
    if np.ptp(log.command, axis=0).max() < _STILL:
        raise RobotLogError(
            f"{log.source}: no command ever changes; expected commands that move all joints, now"
            " fast, now slowly"
        )


def _check_angles(log: RobotLog) -> None:
    if np.ptp(log.angle, axis=0).max() < _STILL:
        raise RobotLogError(
            f"{log.source}: no angle ever changes, whatever is commanded; are brakes on, or columns"
            " taken for others?"
        )
    expected = 0.5 * (log.velocity[1:] + log.velocity[:-1]) * np.diff(log.time)[:, None]
    jumps = np.argwhere(np.abs(np.diff(log.angle, axis=0) - expected) > np.pi)
    if len(jumps):
        row, joint = map(int, jumps[0])
        step = log.angle[row + 1, joint] - log.angle[row, joint]
        raise RobotLogError(
            f"{log.source}: row {row + 1 + FIRST_ROW}, column angle_{JOINT_NAMES[joint]}: jumps by"
            f" {step:.3g}, which its velocity does not explain; expected rad without steps of 2π,"
            " so unwrap the angles, or check their unit"
        )
