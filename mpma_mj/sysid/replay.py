"""Simulation of a log's commands, in windows that start from logged states."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from mpma_mj.errors import DivergedError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.sysid.log import FIRST_ROW, RobotLog

__all__ = ["Replay"]

Array = NDArray[np.float64]

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_START_TIME = 1.0  # s; MuJoCo resets a diverged simulation to time 0, which shows against this
_VELOCITY = 0.1  # s; weight of velocities: noise of 0.01 rad/s counts as 0.001 rad (choice)


class Replay:
    """Windows of a log, each simulated from the logged state at its start.

    Attributes:
        rows: Rows of the log that are compared, those of each of W windows after its first,
            shape (W, R).
        logged: Logged angles, rad, and velocities, rad/s, shape (W, R, 16).
    """

    def __init__(
        self,
        pool: rollout.Rollout,
        model: mujoco.MjModel,
        log: RobotLog,
        starts: NDArray[np.intp],
        length: int,
        steps: int,
    ) -> None:
        """Cut windows out of a log.

        Args:
            pool: Threads that simulate.
            model: The arms; scaled copies of them can be simulated.
            log: The log.
            starts: First row of each window, shape (W,); late commands come from rows before.
            length: Number R of rows of a window after its first.
            steps: Physics steps from row to row.
        """
        self._pool = pool
        self._commands = np.zeros((len(log), model.nu))
        self._commands[:, [int(model.actuator(name).id) for name in JOINT_NAMES]] = log.command
        self._starts = starts
        self._steps = steps
        self._columns = [1 + int(model.joint(name).qposadr[0]) for name in JOINT_NAMES]
        self._columns += [1 + model.nq + int(model.joint(name).dofadr[0]) for name in JOINT_NAMES]
        self._data = [mujoco.MjData(model) for _ in range(max(1, pool.nthread))]
        state = np.zeros(mujoco.mj_stateSize(model, _STATE))
        mujoco.mj_getState(model, self._data[0], state, _STATE)
        state[0] = _START_TIME
        states = np.hstack([log.angle, log.velocity])  # (T, 16)
        self._states = np.tile(state, (len(starts), 1))  # (W, time, positions, velocities, …)
        self._states[:, self._columns] = states[starts]
        self.rows = starts[:, None] + np.arange(1, length + 1)
        self.logged = states[self.rows]

    def simulate(self, model: mujoco.MjModel, latency: float) -> Array:
        """Return angles, rad, and velocities, rad/s, of simulated arms, shape (W, R, 16).

        Args:
            model: Arms with parameters to try.
            latency: Physics steps from a command to its effect; in the step in which a command
                takes effect, its mean with the one before acts.

        Raises:
            DivergedError: A simulation diverged; names the row of the log at which it started.
        """
        whole = math.floor(latency)
        late = latency - whole
        count = self.rows.shape[1] * self._steps
        moments = self._starts[:, None] * self._steps + np.arange(count) - whole
        controls = (1.0 - late) * self._commands[moments // self._steps]
        controls += late * self._commands[(moments - 1) // self._steps]
        models = [model] * len(self._states)
        states, _ = self._pool.rollout(models, self._data, self._states, controls, nstep=count)
        states = states[:, self._steps - 1 :: self._steps]
        diverged = ~np.isfinite(states).all(axis=(1, 2)) | (states[:, -1, 0] <= _START_TIME)
        if diverged.any():
            row = self._starts[int(diverged.argmax())] + FIRST_ROW
            raise DivergedError(
                f"simulated arms diverge from the state in row {row} of the log; check the units"
                " of its angles and velocities (rad, rad/s)"
            )
        return states[..., self._columns]

    def residual(self, model: mujoco.MjModel, latency: float) -> Array:
        """Return angles and weighted velocities, simulated less logged, shape (W · R · 16,).

        The mean of each joint's angle over a window is subtracted: a velocity servo keeps the
        error of the angle from which it starts, which in a noisy log is noise.
        """
        error = self.simulate(model, latency) - self.logged
        angles, velocities = np.split(error, 2, axis=2)
        angles -= angles.mean(axis=1, keepdims=True)
        velocities *= _VELOCITY
        return error.ravel()
