"""Feedback controller: joint velocities proportional to the posture error."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.utils.clipping import clip

__all__ = ["feedback_action", "followed", "joint_error"]

Array = NDArray[np.float64]


def followed(observation: Mapping[str, Array], name: str) -> Array:
    """Return what arms follow of an observation.

    Args:
        observation: An observation.
        name: "reference" or "target".

    Returns:
        Joint angles, shape (..., 8), rad, where the motion has feasible ones; else the posture,
        shape (..., 12).
    """
    angles = observation.get(f"{name}_angles")
    return observation[name] if angles is None else angles


def joint_error(
    joint_angles: Array, reference: Array, kinematics: ArmKinematics = TWO_ARMS
) -> Array:
    """Compute the difference from the joint angles to those of the demonstrated posture.

        e = wrap(q' - q)

    Where an angle is nearly undefined, noise on the posture becomes a large error of an angle that
    hardly moves the arm. `ArmKinematics.correction` suppresses such errors. Demonstrated joint
    angles need none of that.

    Args:
        joint_angles: Joint angles q, shape (..., 8), rad.
        reference: Demonstrated posture, shape (..., 12), or joint angles q', shape (..., 8), rad.
        kinematics: Kinematics of the arms.

    Returns:
        Error, shape (..., 8), rad, on the nearer branch.
    """
    if reference.shape[-1] == len(kinematics.joint_names):
        return kinematics.step_to(reference, near=joint_angles)
    return kinematics.correction(reference, near=joint_angles)


def feedback_action(
    joint_angles: Array,
    reference: Array,
    max_joint_speed: Array,
    control_timestep: float,
    kinematics: ArmKinematics = TWO_ARMS,
) -> Array:
    """Compute the action that corrects the error within one control step.

        u_fb = clip(e / (Δt · v_max), -1, 1)

    Args:
        joint_angles: Joint angles, shape (..., 8), rad.
        reference: Demonstrated posture, shape (..., 12), or joint angles, shape (..., 8), rad.
        max_joint_speed: Speed of each joint at action 1, shape (8,), rad/s.
        control_timestep: Δt, s.
        kinematics: Kinematics of the arms.

    Returns:
        Action, shape (..., 8), in [-1, 1].
    """
    error = joint_error(joint_angles, reference, kinematics)
    return clip(error / (control_timestep * max_joint_speed))
