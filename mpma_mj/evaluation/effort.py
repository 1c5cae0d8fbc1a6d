"""Effort of an episode: torques and work of the actuators."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.step_rules import top_speeds
from mpma_mj.trace import Trace
from mpma_mj.utils.clipping import clip

__all__ = ["Effort", "actuator_torque", "effort"]

Array = NDArray[np.float64]

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


@dataclass(frozen=True, eq=False)
class Effort:
    """Torques and velocities in an episode, for each physics step.

    Attributes:
        torque: Torque of each actuator, shape (N, 8), N m.
        velocity: Mean joint velocity of each step, shape (N, 8), rad/s.
        timestep: Time of a physics step, s.
    """

    torque: Array
    velocity: Array
    timestep: float

    @property
    def mean_torque(self) -> float:
        """Mean size of the torque over time and joints, N m."""
        return float(np.mean(np.abs(self.torque)))

    @property
    def peak_torque(self) -> float:
        """Largest torque of any joint, N m."""
        return float(np.max(np.abs(self.torque)))

    @property
    def power(self) -> Array:
        """Mechanical power that each actuator gives to its joint, shape (N, 8), W."""
        return self.torque * self.velocity

    @property
    def work(self) -> float:
        """Mechanical work Σ_j ∫|τ_j q̇_j| dt, J: braking counts as driving does."""
        return float(np.sum(np.abs(self.power))) * self.timestep


def effort(trace: Trace, options: EnvironmentOptions, rate: float) -> Effort | None:
    """Return the effort of an episode, by simulating it again with the same actions.

    Args:
        trace: Signals of the episode, as `record_epoch` returns them.
        options: Options of its environment; none that delays or pushes, no plants and no
            ranges of their options.
        rate: Control steps per second, Hz.

    Returns:
        The effort; None of ideal arms, which have no mass.
    """
    if options.arms == "kinematic":
        return None
    arms = PhysicsArms.make(options)
    model, timestep = arms.model.ptr, arms.timestep()
    joints = arms.kinematics.joint_names
    speeds = top_speeds(arms.max_joint_speed, joints, options.locked_joint)
    control = np.zeros((len(trace), model.nu))
    control[:, arms.actuator_indices] = clip(trace.action) * speeds
    control = np.repeat(control, round(1.0 / rate / timestep), axis=0)
    arms.set_joint_state(trace.joint_angles[0], trace.joint_velocities[0])
    start = np.empty(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, arms.data.ptr, start, _STATE)
    states, _ = rollout.rollout(model, mujoco.MjData(model), start, control)
    velocities = np.concatenate([start[None], states[0]])[:, 1 + model.nq : 1 + model.nq + model.nv]
    velocity = velocities[:, arms.dof_indices]
    kv = -model.actuator_biasprm[arms.actuator_indices, 2]
    limit = np.where(
        model.actuator_forcelimited[arms.actuator_indices] > 0,
        model.actuator_forcerange[arms.actuator_indices, 1],
        np.inf,
    )
    aim = arms.plant_gains[0] * control[:, arms.actuator_indices]
    torque = actuator_torque(aim, velocity, kv, limit)
    return Effort(torque, 0.5 * (velocity[:-1] + velocity[1:]), timestep)


def actuator_torque(control: Array, velocity: Array, kv: Array, limit: Array) -> Array:
    """Return the torques of velocity actuators as MuJoCo's implicit integrators apply them.

        τ = kv (u - v⁺)        ±limit where kv (u - v) is beyond it

    v being the velocity before a step and v⁺ that after it.

    Args:
        control: Commanded velocities u of N steps, shape (N, 8), rad/s.
        velocity: Velocities before each step and after the last, shape (N + 1, 8), rad/s.
        kv: Gains, shape (8,), N m s/rad.
        limit: Largest torques, shape (8,), N m.

    Returns:
        Torques, shape (N, 8), N m.
    """
    before = kv * (control - velocity[:-1])
    after = kv * (control - velocity[1:])
    return np.where(np.abs(before) < limit, after, np.clip(before, -limit, limit))
