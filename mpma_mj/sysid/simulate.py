"""Simulated arms that are given a log's commands, from the log's states on."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from mpma_mj.errors import DivergedError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.sysid.log import FIRST_ROW, RobotLog
from mpma_mj.utils.system import processors

__all__ = ["FeatureReplay", "threads"]

Array = NDArray[np.float64]

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
# Where numbers run away MuJoCo starts a simulation over at time 0; from any other it shows.
_BEGIN = 1.0


@contextlib.contextmanager
def threads() -> Iterator[rollout.Rollout]:
    """Give threads that simulate, as many as there are processors."""
    count = processors()
    with rollout.Rollout(nthread=0 if count == 1 else count) as pool:  # else the caller's own
        yield pool


class FeatureReplay:
    """Windows of a log, each simulated from the logged state at its begin.

    Attributes:
        rows: Rows of the log that are compared, shape (W, R): those of each window after its
            first.
    """

    def __init__(
        self,
        pool: rollout.Rollout,
        model: mujoco.MjModel,
        log: RobotLog,
        begins: NDArray[np.intp],
        *,
        length: int,
        steps: int,
    ) -> None:
        """Cut the log into windows.

        Args:
            pool: Threads that simulate.
            model: The arms, of which copies with other parameters are simulated.
            log: The log.
            begins: Rows with which windows begin, shape (W,); those before act late in them.
            length: Rows R of a window after its first.
            steps: Physics steps from row to row.
        """
        self._pool = pool
        self._steps = steps
        self._log = log
        self._begins = begins
        self.rows = self._begins[:, None] + np.arange(1, length + 1)
        self._actuators = [int(model.actuator(name).id) for name in JOINT_NAMES]
        self._angles = [1 + int(model.joint(name).qposadr[0]) for name in JOINT_NAMES]
        self._velocities = [1 + model.nq + int(model.joint(name).dofadr[0]) for name in JOINT_NAMES]
        rest = np.zeros(mujoco.mj_stateSize(model, _STATE))
        mujoco.mj_getState(model, mujoco.MjData(model), rest, _STATE)
        rest[0] = _BEGIN
        self._starts = np.tile(rest, (len(self.rows), 1))  # (W, time, positions, velocities, …)
        self._starts[:, self._angles] = log.angle[self._begins]
        self._starts[:, self._velocities] = log.velocity[self._begins]
        self._controls = np.zeros((len(self.rows), length * steps, model.nu))
        self._data = [mujoco.MjData(model) for _ in range(processors())]

    def measured(self) -> tuple[Array, Array]:
        """Return the angles, rad, and velocities, rad/s, of the log, each shape (W, R, 8)."""
        return self._log.angle[self.rows], self._log.velocity[self.rows]

    def simulate(self, model: mujoco.MjModel, latency: int) -> tuple[Array, Array]:
        """Return angles, rad, and velocities, rad/s, of simulated arms, each shape (W, R, 8).

        Args:
            model: The arms, with parameters to try.
            latency: Physics steps until a command acts.

        Raises:
            DivergedError: A simulation ran away.
        """
        moments = self._begins[:, None] * self._steps + np.arange(self._controls.shape[1]) - latency
        self._controls[..., self._actuators] = self._log.command[moments // self._steps]
        states, _ = self._pool.rollout(
            [model] * len(self._starts),
            self._data,
            self._starts,
            self._controls,
            nstep=self._controls.shape[1],
        )
        states = states[:, self._steps - 1 :: self._steps]
        ended = states[:, -1, 0] - _BEGIN
        wrong = ~np.isfinite(states).all(axis=(1, 2)) | (ended <= 0.0)
        if wrong.any():
            row = self._begins[int(wrong.argmax())] + FIRST_ROW
            raise DivergedError(
                f"simulated arms run away where they begin as in row {row} of the log; check the"
                " units of its angles and velocities (rad, rad/s)"
            )
        return states[..., self._angles], states[..., self._velocities]
