"""Geometry of the two arms: simulated by MuJoCo, or kinematic."""

from __future__ import annotations

import functools
from typing import Any, Self

import mujoco
import numpy as np
from dm_control import mujoco as dm_mujoco
from dm_control._render.base import ContextBase
from dm_control.mujoco.wrapper import MjModel
from numpy.typing import NDArray

from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.envs.gl_context import BoundContext
from mpma_mj.envs.model import CompiledPlants, geom_colours
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.randomisation import PlantValues
from mpma_mj.kinematics import SIDES
from mpma_mj.robots.assembly import HANDS

__all__: list[str] = ["KinematicArms", "PhysicsArms", "ideal_move"]

Array = NDArray[np.float64]
Index = slice | NDArray[np.intp]

_GREY = np.array([0.55, 0.55, 0.55, 1.0])  # rgba

# Warnings of MuJoCo when it resets a simulation that diverged.
_WARNINGS = {
    mujoco.mjtWarning.mjWARN_BADQPOS: "angle",
    mujoco.mjtWarning.mjWARN_BADQVEL: "velocity",
    mujoco.mjtWarning.mjWARN_BADQACC: "acceleration",
}


class PhysicsArms(dm_mujoco.Physics):
    """Arms with mass, gravity, and velocity actuators of limited force.

    Attributes:
        divergence: Why the simulation diverged since the last reset; empty if it did not.
        compiled_plants: Models of the plants; one where there are no plants.
        plant_gains: Actuator gain of each plant.
        kinematics: Relation between joint angles and postures.
    """

    divergence = ""
    compiled_plants: CompiledPlants
    plant_gains: tuple[float, ...]
    kinematics: ArmKinematics = TWO_ARMS

    @classmethod
    def make(cls, options: EnvironmentOptions | None = None, *, adjustable: bool = False) -> Self:
        """Return arms.

        Args:
            options: Options of the environment; the defaults if not given.
            adjustable: Whether they can become plants of any payload and gain.

        Raises:
            BadOptionError: A user's model cannot be read, or is incomplete.
        """
        options = options or EnvironmentOptions()
        models = CompiledPlants(options, adjustable=adjustable)
        arms: Self = cls.from_model(MjModel(models.live))
        arms.compiled_plants, arms.kinematics = models, models.compiler.kinematics
        arms.plant_gains = tuple(plant["actuator_gain"] for plant in models.plants)
        return arms

    @property
    def contexts(self) -> Any:
        """What dm_control's `render` and cameras draw with.

        Raises:
            RenderingError: OpenGL does not draw, as in a process that was forked from one that
                has drawn, or in another thread than the first picture.
        """
        contexts = super().contexts
        self._context.get()
        return contexts

    def _make_rendering_contexts(self) -> None:
        """Make them, in dm_control's name, which holds a lock meanwhile."""

        def make() -> ContextBase:
            super(PhysicsArms, self)._make_rendering_contexts()
            return self._contexts.gl

        self._context = BoundContext(make, ContextBase.free)

    @property
    def _joints(self) -> tuple[str, ...]:
        return self.kinematics.joint_names

    @functools.cached_property
    def qpos_indices(self) -> Index:
        """Indices of the eight joints in `qpos`, left arm first."""
        return _as_slice([int(self.model.joint(name).qposadr[0]) for name in self._joints])

    @functools.cached_property
    def dof_indices(self) -> Index:
        """Indices of the eight joints in `qvel`."""
        return _as_slice([int(self.model.joint(name).dofadr[0]) for name in self._joints])

    @functools.cached_property
    def actuator_indices(self) -> Index:
        """Indices of the eight joints' actuators in `ctrl`."""
        return _as_slice([int(self.model.actuator(name).id) for name in self._joints])

    @functools.cached_property
    def hand_ids(self) -> list[int]:
        """Indices of the bodies of the left and the right hand."""
        return [int(self.model.body(name).id) for name in HANDS]

    @functools.cached_property
    def max_joint_speed(self) -> Array:
        """Joint speeds that action 1 commands, shape (8,), rad/s: the actuators' ranges."""
        return self.model.actuator_ctrlrange[self.actuator_indices, 1].copy()

    @functools.cached_property
    def joint_range(self) -> tuple[Array, Array]:
        """Lowest and highest joint angles, each shape (8,), rad; infinite where unlimited."""
        joints = [self.model.joint(name) for name in self._joints]
        limited = np.array([joint.limited[0] for joint in joints], bool)
        low, high = np.array([joint.range for joint in joints]).T
        return np.where(limited, low, -np.inf), np.where(limited, high, np.inf)

    @functools.cached_property
    def segment_lengths(self) -> Array:
        """Lengths of the four segments, shape (4,), m, in the order of `SEGMENT_NAMES`."""
        # At rest, since in the present posture rounding would depend on the first call.
        rest = mujoco.MjData(self.model.ptr)
        mujoco.mj_kinematics(self.model.ptr, rest)
        return np.linalg.norm(self._segments @ rest.site_xpos, axis=1)

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
    def directions(self) -> Array:
        """Matrix that takes site positions to unit vectors, shape (4, number of sites)."""
        return self._segments / self.segment_lengths[:, None]

    @functools.cached_property
    def keypoints(self) -> Array:
        """Matrix K, posture @ K being elbows and wrists from the shoulders, shape (12, 12), m."""
        left, left_forearm, right, right_forearm = self.segment_lengths
        reaches = np.zeros((4, 4))
        reaches[0, :2], reaches[2, 2:] = left, right  # upper arms move wrists, too
        reaches[1, 1], reaches[3, 3] = left_forearm, right_forearm
        return np.asarray(np.kron(reaches, np.eye(3)), np.float64)

    def posture(self) -> Array:
        """Return the posture from the sites' positions, shape (12,), unit vectors."""
        return np.dot(self.directions, self.data.ptr.site_xpos).ravel()

    def joint_angles(self) -> Array:
        """Return the joint angles, shape (8,), rad."""
        return self.data.ptr.qpos[self.qpos_indices].copy()

    def joint_velocities(self) -> Array:
        """Return the joint velocities, shape (8,), rad/s."""
        return self.data.ptr.qvel[self.dof_indices].copy()

    def site_positions(self, posture: Array) -> Array:
        """Return the positions of shoulders, elbows and wrists in a posture.

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

    def set_joint_state(self, joint_angles: Array, joint_velocities: Array) -> None:
        """Set the joint state and update all positions.

        Args:
            joint_angles: Joint angles, shape (8,), rad.
            joint_velocities: Joint velocities, shape (8,), rad/s.
        """
        self.data.ptr.qpos[self.qpos_indices] = joint_angles
        self.data.ptr.qvel[self.dof_indices] = joint_velocities
        mujoco.mj_kinematics(self.model.ptr, self.data.ptr)

    def set_control(self, control: Array) -> None:
        """Command joint velocities, shape (8,), rad/s."""
        self.data.ptr.ctrl[self.actuator_indices] = control

    def set_brightness(self, brightness: float) -> None:
        """Colour the arms: 1 for their own colours, 0 for grey."""
        # As in dm_control's suite, which distinguishes good rewards better than bad ones.
        share, geoms = brightness**4, self._arm_geoms
        self.model.geom_rgba[geoms] = share * self._own_colours[geoms] + (1.0 - share) * _GREY

    @functools.cached_property
    def _arm_geoms(self) -> NDArray[np.intp]:
        """Indices of the geoms that the arms' joints move and that are seen."""
        model = self.model
        moved = {int(model.joint(name).bodyid[0]) for name in self._joints}
        for body in range(model.nbody):  # parents come first
            if int(model.body_parentid[body]) in moved:
                moved.add(body)
        seen = self._own_colours[:, 3] > 0.0
        return np.flatnonzero(np.isin(model.geom_bodyid, list(moved)) & seen)

    @functools.cached_property
    def _own_colours(self) -> Array:
        return geom_colours(self.model)

    def apply_perturbation(self, forces: Array) -> None:
        """Apply forces to left and right hand from now on, shape (2, 3), N."""
        self.data.ptr.xfrc_applied[self.hand_ids, :3] = forces

    def set_plant(self, plant: int) -> None:
        """Continue as the plant of an index, from the same joint state."""
        self.compiled_plants.use(plant)

    def become_plant(self, plant: PlantValues) -> None:
        """Continue as any plant within the options' ranges, from the same joint state."""
        self.compiled_plants.become_plant(plant)

    def step(self, nstep: int = 1) -> None:
        """Simulate a number of physics steps; `divergence` reports afterwards if they failed.

        The result depends on angles, velocities, control and forces alone.

        Args:
            nstep: Number of physics steps.
        """
        model, data = self.model.ptr, self.data.ptr
        began = data.time
        # dm_control's own step updates every quantity and costs as much as the simulation.
        # Observations need joints and sites only, and these are updated.
        mujoco.mj_step(model, data, nstep)
        # MuJoCo checks for divergence when a step begins, so not yet after the last one.
        mujoco.mj_checkPos(model, data)
        mujoco.mj_checkVel(model, data)
        mujoco.mj_kinematics(model, data)
        # MuJoCo then warns and resets the time to 0, which the time shows, except in the first
        # step.
        if data.time <= began or (began == 0.0 and self._diverged_quantities()):
            self._stop()

    def after_reset(self) -> None:
        """Update all positions to the initial joint angles."""
        self.divergence = ""
        super().after_reset()

    def _diverged_quantities(self) -> list[str]:
        """Return the quantities that diverged since the last reset, in words."""
        warnings, model = self.data.ptr.warning, self.model
        diverged = []
        for kind, quantity in _WARNINGS.items():
            if warnings[kind].number:
                addresses = model.jnt_qposadr if quantity == "angle" else model.jnt_dofadr
                joint = int(np.searchsorted(addresses, warnings[kind].lastinfo, "right")) - 1
                name = model.id2name(joint, "joint") or f"joint {joint}"
                diverged.append(f"the {quantity} of {name}")
        return diverged

    def _stop(self) -> None:
        """Let the arms hang at rest, where all numbers are finite."""
        self.divergence = (
            f"the simulation diverged: {' and '.join(self._diverged_quantities())} ran away"
        )
        mujoco.mj_resetData(self.model.ptr, self.data.ptr)
        mujoco.mj_kinematics(self.model.ptr, self.data.ptr)


class KinematicArms(PhysicsArms):
    """Ideal arms: joints move at gain times the commanded velocities, within their ranges."""

    @functools.cached_property
    def actuator_gain(self) -> float:
        """Factor on commanded velocities."""
        return self.plant_gains[0]

    def set_plant(self, plant: int) -> None:
        """Continue as another plant, which differs in its gain; see `PhysicsArms.set_plant`."""
        self.actuator_gain = self.plant_gains[plant]

    def become_plant(self, plant: PlantValues) -> None:
        """Continue with another gain; see `PhysicsArms.become_plant`."""
        self.actuator_gain = plant["actuator_gain"]

    def forward(self) -> None:
        """Compute all positions; there are no forces."""
        mujoco.mj_kinematics(self.model.ptr, self.data.ptr)
        mujoco.mj_camlight(self.model.ptr, self.data.ptr)

    def step(self, nstep: int = 1) -> None:
        """Integrate the commanded joint velocities: q ← clip(q + Δt·gain·u)."""
        data = self.data.ptr
        elapsed = nstep * self.timestep()
        before = data.qpos[self.qpos_indices].copy()
        control, gain = data.ctrl[self.actuator_indices], self.actuator_gain
        after = ideal_move(before, control, elapsed, self.joint_range, gain)
        data.qpos[self.qpos_indices] = after
        data.qvel[self.dof_indices] = (after - before) / elapsed
        data.time += elapsed
        mujoco.mj_kinematics(self.model.ptr, data)


def ideal_move(
    joint_angles: Array,
    velocity: Array,
    elapsed: float,
    joint_range: tuple[Array, Array],
    gain: float | Array = 1.0,
) -> Array:
    """Return the joint angles of ideal arms after some time.

        q ← clip(q + Δt·gain·v, lowest, highest)

    Args:
        joint_angles: Joint angles q, shape (..., 8), rad.
        velocity: Commanded velocities v, shape (..., 8), rad/s.
        elapsed: Time Δt, s.
        joint_range: Lowest and highest joint angles, each shape (8,), rad.
        gain: Factor on the commanded velocities, a number or shape (..., 1).
    """
    return np.clip(joint_angles + elapsed * gain * velocity, *joint_range)


def _as_slice(indices: list[int]) -> Index:
    """Return indices as a slice where they are consecutive, since a view is fast."""
    first = indices[0]
    if indices == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return np.array(indices)
