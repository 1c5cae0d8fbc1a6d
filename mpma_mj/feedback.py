"""The feedback controller: what joint velocities would undo the present error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.utils.clipping import clip

__all__ = ["feedback_action", "joint_error"]

Array = NDArray[np.float64]


def joint_error(joint_angles: Array, reference: Array) -> Array:
    """Compute the way from the joint angles that are to those of the demonstrated posture.

        e = wrap(q' - q)        abduction weighted by cos²(flexion), rotation by sin(elbow)

    Where an angle is nearly undefined, noise on the posture becomes a large error of the angle
    that would hardly move the arm. The weights keep the arms from chasing it (choice).

    Args:
        joint_angles: Joint angles q, shape (..., 8), rad.
        reference: Demonstrated posture, shape (..., 12).

    Returns:
        Error, shape (..., 8), rad, in [-π, π), on the branch that is the shorter way.
    """
    wanted = kinematics.angles_from_posture(reference, near=joint_angles)
    weight = kinematics.segment_leverage(wanted)
    weight[..., ::4] **= 2
    return weight * (wanted - joint_angles)


def feedback_action(
    joint_angles: Array, reference: Array, max_joint_speed: Array, control_timestep: float
) -> Array:
    """Compute the action that would undo the error within one control step.

        u_fb = clip(e / (Δt · v_max), -1, 1)

    Args:
        joint_angles: Joint angles, shape (..., 8), rad.
        reference: Demonstrated posture, shape (..., 12).
        max_joint_speed: Speed of each joint at action 1, shape (8,), rad/s.
        control_timestep: Δt, s.

    Returns:
        Action, shape (..., 8), in [-1, 1].
    """
    error = joint_error(joint_angles, reference)
    return clip(error / (control_timestep * max_joint_speed))
