"""Many pairs of arms at once: simulated by MuJoCo's thread pool, or moved ideally."""

from __future__ import annotations

import abc
import ctypes
import functools
import os
import weakref

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from mpma_mj.envs.physics import KinematicArms, PhysicsArms, ideal_move

__all__ = ["Batch", "KinematicBatch", "PhysicsBatch", "chunk_size", "make_batch"]

Array = NDArray[np.float64]

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_CONTROL = mujoco.mjtState.mjSTATE_CTRL
_FORCES = mujoco.mjtState.mjSTATE_XFRC_APPLIED
# Where numbers run away MuJoCo starts a simulation over at time 0; from any other it shows.
_BEGIN = 1.0


class Batch(abc.ABC):
    """N pairs of arms that move together, each as it would alone."""

    def __init__(self, arms: PhysicsArms, count: int, nstep: int) -> None:
        """Put all arms where a reset puts them.

        Args:
            arms: A pair of arms like all of them.
            count: Number N of pairs.
            nstep: Physics steps of a control step.
        """
        self._arms = arms
        self._nstep = nstep
        model = arms.model.ptr
        self._rest = np.zeros(mujoco.mj_stateSize(model, _STATE))
        mujoco.mj_getState(model, mujoco.MjData(model), self._rest, _STATE)
        self._rest[0] = _BEGIN
        self._state = np.tile(self._rest, (count, 1))  # (N, time, positions, velocities, …)
        self._qpos = slice(1, 1 + model.nq)
        self._moving = slice(1, 1 + model.nq + model.nv)
        self._angles = np.arange(1, 1 + model.nq)[arms.qpos_indices]
        self._velocities = np.arange(1 + model.nq, 1 + model.nq + model.nv)[arms.dof_indices]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self._state)

    def set_joint_state(self, row: int, joint_angles: Array, joint_velocities: Array) -> None:
        """Set the state of one pair.

        Args:
            row: Its number.
            joint_angles: Joint angles, shape (8,), rad.
            joint_velocities: Joint velocities, shape (8,), rad/s.
        """
        self._state[row] = self._rest
        self._state[row, self._angles] = joint_angles
        self._state[row, self._velocities] = joint_velocities

    @abc.abstractmethod
    def step(self, control: Array, forces: Array | None = None) -> NDArray[np.bool_]:
        """Move all arms for one control step.

        Args:
            control: Commanded joint velocities, shape (N, 8), rad/s.
            forces: Forces on left and right hands, shape (N, 2, 3), N.

        Returns:
            Whose simulation has diverged, shape (N,); those arms hang at rest.
        """

    def joint_angles(self) -> Array:
        """Return the joint angles, shape (N, 8), rad."""
        return self._state[:, self._angles]

    def joint_velocities(self) -> Array:
        """Return the joint velocities, shape (N, 8), rad/s."""
        return self._state[:, self._velocities]

    def posture(self) -> Array:
        """Return the postures from the sites' positions, shape (N, 12), unit vectors."""
        model, data = self._arms.model.ptr, self._arms.data.ptr
        qpos, site_xpos, directions = data.qpos, data.site_xpos, self._arms.directions
        posture = np.empty((len(self), 4, 3))
        for one, posed in zip(posture, self._state[:, self._qpos], strict=True):
            qpos[:] = posed
            mujoco.mj_kinematics(model, data)
            np.dot(directions, site_xpos, out=one)
        return posture.reshape(-1, 12)

    def close(self) -> None:  # noqa: B027, there need not be anything
        """Give back what the batch holds."""


class PhysicsBatch(Batch):
    """Simulated arms, stepped by the thread pool of `mujoco.rollout`."""

    def __init__(
        self, arms: PhysicsArms, count: int, nstep: int, *, perturbed: bool, threads: int
    ) -> None:
        """Start the threads.

        Args:
            arms: A pair of arms like all of them.
            count: Number N of pairs.
            nstep: Physics steps of a control step.
            perturbed: Whether there may be forces on the hands.
            threads: Most threads that simulate.
        """
        super().__init__(arms, count, nstep)
        model = arms.model.ptr
        threads = min(count, threads)
        self._chunk = chunk_size(count, threads)
        self._threads = threads
        self._pool: rollout.Rollout | None = None
        self._start_threads()
        self._models = [model] * count
        self._data = [mujoco.MjData(model) for _ in range(threads)]
        self._trajectory = np.zeros((count, nstep, len(self._rest)))
        self._applies = _CONTROL | _FORCES if perturbed else _CONTROL
        self._applied = np.zeros((count, nstep, mujoco.mj_stateSize(model, self._applies)))
        self._control = self._applied[..., : model.nu]
        self._force = self._applied[..., model.nu :].reshape(count, nstep, -1, 6)

    def step(self, control: Array, forces: Array | None = None) -> NDArray[np.bool_]:
        """Simulate all arms for one control step; see `Batch.step`."""
        self._control[..., self._arms.actuator_indices] = control[:, None]
        if forces is not None:
            self._force[:, :, self._arms.hand_ids, :3] = forces[:, None]
        if self._pool is None:
            self._start_threads()
        assert self._pool is not None
        began = self._state[:, 0].copy()
        self._pool.rollout(
            self._models,
            self._data,
            self._state,
            self._applied,
            control_spec=self._applies,
            skip_checks=True,
            nstep=self._nstep,
            state=self._trajectory,
            chunk_size=self._chunk,
        )
        self._state[:] = self._trajectory[:, -1]
        # MuJoCo looks for numbers that run away when a step begins, so not yet after the last.
        bounded = np.abs(self._state[:, self._moving]) <= mujoco.mjMAXVAL
        diverged = (self._state[:, 0] <= began) | ~bounded.all(axis=1)
        self._state[diverged] = self._rest
        return diverged

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.close()

    def _start_threads(self) -> None:
        _mind_forks()
        alone = self._threads == 1  # the caller's own thread does
        self._pool = rollout.Rollout(nthread=0 if alone else self._threads)
        _with_threads.add(self)

    def leave_parents_threads(self) -> None:
        """Forget a pool whose threads the parent process has; to end it would wait for ever."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._pool))  # never ended
        self._pool = None


class KinematicBatch(Batch):
    """Ideal arms: joints move at exactly the commanded velocities, within their ranges."""

    def step(self, control: Array, forces: Array | None = None) -> NDArray[np.bool_]:
        """Move all arms for one control step; they do not feel forces."""
        elapsed = self._nstep * self._arms.timestep()
        before = self.joint_angles()
        after = ideal_move(before, control, elapsed, self._arms.joint_range)
        self._state[:, self._angles] = after
        self._state[:, self._velocities] = (after - before) / elapsed
        return np.zeros(len(self), bool)


_with_threads: weakref.WeakSet[PhysicsBatch] = weakref.WeakSet()


@functools.cache
def _mind_forks() -> None:
    """See to it, once, that a forked process starts threads of its own."""

    def leave() -> None:
        for batch in _with_threads:
            batch.leave_parents_threads()

    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=leave)


def chunk_size(count: int, threads: int) -> int:
    """Return how many pairs of arms a thread takes at once.

    A twentieth of a thread's share, as `rollout` has it, costs a tenth more; the whole share makes
    all wait for a thread that is held up.
    """
    return -(-count // (2 * threads))


def make_batch(
    arms: PhysicsArms, count: int, nstep: int, *, perturbed: bool, threads: int
) -> Batch:
    """Return N pairs of arms of the same kind as one pair; see `PhysicsBatch`."""
    if isinstance(arms, KinematicArms):
        return KinematicBatch(arms, count, nstep)
    return PhysicsBatch(arms, count, nstep, perturbed=perturbed, threads=threads)
