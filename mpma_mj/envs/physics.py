"""The geometry of the two arms: simulated by MuJoCo, or moved ideally."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Self

import mujoco
import numpy as np
from dm_control import mujoco as dm_mujoco
from numpy.typing import NDArray

from mpma_mj.arm import JOINT_NAMES, SIDES

__all__ = ["MODEL_PATH", "KinematicArms", "PhysicsArms"]

Array = NDArray[np.float64]

MODEL_PATH = Path(__file__).parent.parent / "assets" / "two_arm.xml"


class PhysicsArms(dm_mujoco.Physics):
    """Arms with mass, gravity, and velocity actuators of limited force."""

    diverged = False
    """Whether the simulation has failed since the last reset."""

    @classmethod
    def make(cls) -> Self:
        """Return arms made from the package's own model."""
        return cls.from_xml_path(str(MODEL_PATH))

    @functools.cached_property
    def max_joint_speed(self) -> Array:
        """Joint speeds that action 1 commands, shape (8,), rad/s: the actuators' ranges."""
        return self.named.model.actuator_ctrlrange[list(JOINT_NAMES), 1].copy()

    @functools.cached_property
    def joint_range(self) -> tuple[Array, Array]:
        """Lowest and highest joint angles, each shape (8,), rad; infinite where unlimited."""
        limited = self.model.jnt_limited.astype(bool)
        low, high = self.model.jnt_range.T
        return np.where(limited, low, -np.inf), np.where(limited, high, np.inf)

    @functools.cached_property
    def segment_lengths(self) -> Array:
        """Lengths of the four segments, shape (4,), m, in the order of `SEGMENT_NAMES`."""
        return np.linalg.norm(self._segments @ self.data.site_xpos, axis=1)

    @functools.cached_property
    def _segments(self) -> Array:
        """Matrix that takes site positions to segment vectors, shape (4, number of sites)."""
        site = {self.model.id2name(i, "site"): i for i in range(self.model.nsite)}
        matrix = np.zeros((4, self.model.nsite))
        ends = [("shoulder", "elbow"), ("elbow", "wrist")]
        for row, (side, (start, end)) in enumerate((s, e) for s in SIDES for e in ends):
            matrix[row, site[f"{side}_{end}"]] = 1.0
            matrix[row, site[f"{side}_{start}"]] = -1.0
        return matrix

    @functools.cached_property
    def _directions(self) -> Array:
        return self._segments / self.segment_lengths[:, None]

    def posture(self) -> Array:
        """Return the posture from the sites' positions, shape (12,), unit vectors."""
        return np.dot(self._directions, self.data.ptr.site_xpos).ravel()

    def joint_angles(self) -> Array:
        """Return the joint angles, shape (8,), rad."""
        return self.data.ptr.qpos.copy()

    def joint_velocities(self) -> Array:
        """Return the joint velocities, shape (8,), rad/s."""
        return self.data.ptr.qvel.copy()

    def site_positions(self, posture: Array) -> Array:
        """Return where shoulders, elbows and wrists are in a posture.

        Args:
            posture: Posture, shape (..., 12).

        Returns:
            Positions, shape (..., 2, 3, 3), m: left and right arm; shoulder, elbow, wrist; xyz.
        """
        shoulders = np.stack([self.named.data.site_xpos[f"{side}_shoulder"] for side in SIDES])
        segments = posture.reshape(*posture.shape[:-1], 2, 2, 3) * self.segment_lengths.reshape(
            2, 2, 1
        )
        start = np.broadcast_to(shoulders[:, None, :], (*segments.shape[:-2], 1, 3))
        return np.concatenate([start, start + np.cumsum(segments, axis=-2)], axis=-2)

    def set_control(self, control: Array) -> None:
        """Command joint velocities, shape (8,), rad/s."""
        self.data.ptr.ctrl[:] = control

    def step(self, nstep: int = 1) -> None:
        """Simulate `nstep` steps; `diverged` says afterwards whether they were possible."""
        model, data = self.model.ptr, self.data.ptr
        if not math.isfinite(np.dot(data.ctrl, data.ctrl)):
            self.diverged = True
            return
        began = data.time
        ends = began + nstep * model.opt.timestep
        # dm_control's own step looks after every quantity and costs as much as the simulation.
        # What is seen of the arms after it are joints and sites, and these are brought up to date.
        mujoco.mj_step(model, data, nstep)
        mujoco.mj_kinematics(model, data)
        # Where numbers run away MuJoCo warns and starts over at time 0, which shows by the time,
        # but not in the first step.
        if abs(data.time - ends) > 0.5 * model.opt.timestep:
            self.diverged = True
        if began == 0.0 and data.warning.number.any():
            self.diverged = True

    def after_reset(self) -> None:
        """Bring all positions up to date with the initial joint angles."""
        self.diverged = False
        super().after_reset()


class KinematicArms(PhysicsArms):
    """Ideal arms: joints move at exactly the commanded velocities, within their ranges."""

    def forward(self) -> None:
        """Compute where everything is; there are no forces."""
        mujoco.mj_kinematics(self.model.ptr, self.data.ptr)
        mujoco.mj_camlight(self.model.ptr, self.data.ptr)

    def step(self, nstep: int = 1) -> None:
        """Integrate the commanded joint velocities: q ← clip(q + Δt·u)."""
        data = self.data
        if not np.isfinite(data.ctrl).all():
            self.diverged = True
            return
        before = data.qpos.copy()
        elapsed = nstep * self.timestep()
        np.clip(before + elapsed * data.ctrl, *self.joint_range, out=data.qpos)
        data.qvel[:] = (data.qpos - before) / elapsed
        data.time += elapsed
        mujoco.mj_kinematics(self.model.ptr, data.ptr)
