"""Batch of arms: simulated by MuJoCo's thread pool, or kinematic."""

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
from mpma_mj.envs.randomisation import PlantValues

__all__: list[str] = ["Batch", "KinematicBatch", "PhysicsBatch", "chunk_size", "make_batch"]

Array = NDArray[np.float64]

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_CONTROL = mujoco.mjtState.mjSTATE_CTRL
_FORCES = mujoco.mjtState.mjSTATE_XFRC_APPLIED
# MuJoCo resets a simulation that diverges to time 0, which is detected from any other time.
_BEGIN = 1.0


class Batch(abc.ABC):
    """N pairs of arms that move together, each as it would alone."""

    def __init__(self, arms: PhysicsArms, count: int, nstep: int) -> None:
        """Set all arms to the state after a reset.

        Args:
            arms: One pair of arms, as model of all of them.
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
        """Return the number of pairs of arms."""
        return len(self._state)

    def set_joint_state(self, row: int, joint_angles: Array, joint_velocities: Array) -> None:
        """Set the state of one pair.

        Args:
            row: Index of the pair.
            joint_angles: Joint angles, shape (8,), rad.
            joint_velocities: Joint velocities, shape (8,), rad/s.
        """
        self._state[row] = self._rest
        self._state[row, self._angles] = joint_angles
        self._state[row, self._velocities] = joint_velocities

    @abc.abstractmethod
    def set_plants(self, plants: NDArray[np.intp]) -> None:
        """Continue as other plants, given by index, shape (N,), from the same joint states."""

    @abc.abstractmethod
    def become_plant(self, row: int, plant: PlantValues) -> None:
        """Let one pair, given by its index, continue as any plant within the options' ranges."""

    @abc.abstractmethod
    def step(self, control: Array, forces: Array | None = None) -> NDArray[np.bool_]:
        """Move all arms for one control step.

        Args:
            control: Commanded joint velocities, shape (N, 8), rad/s.
            forces: Forces on left and right hands, shape (N, 2, 3), N.

        Returns:
            Whether each simulation diverged, shape (N,); those arms hang at rest.
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

    def pose(self, row: int) -> None:
        """Give the model of all pairs the joint angles of one, to draw it."""
        self._arms.data.qpos[:] = self._state[row, self._qpos]
        mujoco.mj_kinematics(self._arms.model.ptr, self._arms.data.ptr)

    def close(self) -> None:  # noqa: B027, subclasses without resources need none
        """Release the resources of the batch."""


class PhysicsBatch(Batch):
    """Simulated arms, stepped by the thread pool of `mujoco.rollout`."""

    def __init__(
        self, arms: PhysicsArms, count: int, nstep: int, *, perturbed: bool, threads: int
    ) -> None:
        """Start the threads.

        Args:
            arms: One pair of arms, as model of all of them.
            count: Number N of pairs.
            nstep: Physics steps of a control step.
            perturbed: Whether there may be forces on the hands.
            threads: Greatest number of simulating threads.
        """
        super().__init__(arms, count, nstep)
        model = arms.model.ptr
        threads = min(count, threads)
        self._chunk = chunk_size(count, threads)
        self._threads = threads
        self._pool: rollout.Rollout | None = None
        self._start_threads()
        self._models: list[mujoco.MjModel] = [model] * count
        self._data = [mujoco.MjData(model) for _ in range(threads)]
        self._trajectory = np.zeros((count, nstep, len(self._rest)))
        self._applies = _CONTROL | _FORCES if perturbed else _CONTROL
        self._applied = np.zeros((count, nstep, mujoco.mj_stateSize(model, self._applies)))
        self._control = self._applied[..., : model.nu]
        self._force = self._applied[..., model.nu :].reshape(count, nstep, -1, 6)

    def pose(self, row: int) -> None:
        """Give the model of all pairs the parameters of one, too, as its payload is seen."""
        self._arms.compiled_plants.become(self._models[row])
        super().pose(row)

    def set_plants(self, plants: NDArray[np.intp]) -> None:
        """Choose the model of each pair; see `Batch.set_plants`."""
        models = self._arms.compiled_plants.models
        self._models = [models[plant] for plant in plants.tolist()]

    def become_plant(self, row: int, plant: PlantValues) -> None:
        """Compile the model of one pair; see `Batch.become_plant`."""
        self._models[row] = self._arms.compiled_plants.compiler.compile(plant)

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
        # MuJoCo checks for divergence when a step begins, so not yet after the last one.
        bounded = np.abs(self._state[:, self._moving]) <= mujoco.mjMAXVAL
        diverged = (self._state[:, 0] <= began) | ~bounded.all(axis=1)
        self._state[diverged] = self._rest
        return diverged

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.close()

    def _start_threads(self) -> None:
        _register_fork_handler()
        single = self._threads == 1  # the caller's thread is enough
        self._pool = rollout.Rollout(nthread=0 if single else self._threads)
        _with_threads.add(self)

    def abandon_pool(self) -> None:
        """Abandon a pool whose threads belong to the parent process; ending it would hang."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._pool))  # never deleted
        self._pool = None


class KinematicBatch(Batch):
    """Ideal arms: joints move at gain times the commanded velocities, within their ranges."""

    def __init__(self, arms: PhysicsArms, count: int, nstep: int) -> None:
        """Set all arms to the state after a reset; see `Batch`."""
        super().__init__(arms, count, nstep)
        self.set_plants(np.zeros(count, np.intp))

    def set_plants(self, plants: NDArray[np.intp]) -> None:
        """Choose the gain of each pair; see `Batch.set_plants`."""
        self._gain = np.array(self._arms.plant_gains)[plants, None]  # (N, 1)

    def become_plant(self, row: int, plant: PlantValues) -> None:
        """Set the gain of one pair; see `Batch.become_plant`."""
        self._gain[row] = plant["actuator_gain"]

    def step(self, control: Array, forces: Array | None = None) -> NDArray[np.bool_]:
        """Move all arms for one control step; forces have no effect."""
        elapsed = self._nstep * self._arms.timestep()
        before = self.joint_angles()
        after = ideal_move(before, control, elapsed, self._arms.joint_range, self._gain)
        self._state[:, self._angles] = after
        self._state[:, self._velocities] = (after - before) / elapsed
        return np.zeros(len(self), bool)


_with_threads: weakref.WeakSet[PhysicsBatch] = weakref.WeakSet()


@functools.cache
def _register_fork_handler() -> None:
    """Let forked processes start their own threads; registered once."""

    def abandon_pools() -> None:
        for batch in _with_threads:
            batch.abandon_pool()

    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=abandon_pools)


def chunk_size(count: int, threads: int) -> int:
    """Return the number of pairs of arms that a thread simulates at once.

    The default of `rollout`, a twentieth of a thread's share, takes a tenth longer; with the whole
    share all threads wait for one that is interrupted.

    Args:
        count: Number of pairs.
        threads: Number of threads.
    """
    return -(-count // (2 * threads))


def make_batch(
    arms: PhysicsArms, count: int, nstep: int, *, perturbed: bool, threads: int
) -> Batch:
    """Return N pairs of arms of the same kind as one pair; see `PhysicsBatch`."""
    if isinstance(arms, KinematicArms):
        return KinematicBatch(arms, count, nstep)
    return PhysicsBatch(arms, count, nstep, perturbed=perturbed, threads=threads)
