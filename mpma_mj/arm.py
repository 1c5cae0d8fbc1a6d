"""Kinematics of two arms of four degrees of freedom: postures to joint angles and back.

A posture is what a demonstration shows: for each arm the unit vectors shoulder→elbow `u` and
elbow→wrist `f`, in the torso frame (x forward, y left, z up). An arm hangs along -z at zero
angles. With abduction a, flexion b, rotation c, elbow flexion e, the left arm is

    R = Rx(a) Ry(-b) Rz(c)        u = R (0, 0, -1)        f = R Ry(-e) (0, 0, -1)

and the right arm its mirror image (y → -y), so that equal angles give mirrored postures.
Abduction raises the arm sideways, flexion raises it forward, positive rotation is outward,
elbow flexion brings the forearm forward. Written out,

    u = (sin b, sin a cos b, -cos a cos b)
    g = (Rx(a) Ry(-b))ᵀ f = (sin e cos c, sin e sin c, -cos e)

which is inverted in closed form. Every posture has two solutions, (a, b, c, e) and
(a+π, π-b, c+π, e), each modulo 2π: the *branches*. Two places are singular: an upper arm
straight forward or back (cos b = 0, a undefined) and a straight elbow (sin e = 0, c
undefined). This order of axes is chosen because hanging and overhead arms, where dances
live, are then regular.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "JOINT_NAMES",
    "SEGMENT_NAMES",
    "SIDES",
    "angles_from_posture",
    "continuous_angles",
    "posture_from_angles",
    "segment_leverage",
    "wrap",
]

Array = NDArray[np.float64]

SIDES = ("left", "right")
JOINT_NAMES = tuple(
    f"{side}_{joint}"
    for side in SIDES
    for joint in ("shoulder_abduction", "shoulder_flexion", "shoulder_rotation", "elbow")
)
SEGMENT_NAMES = tuple(f"{side}_{part}" for side in SIDES for part in ("upper_arm", "forearm"))

# Below this sine or cosine an angle counts as undefined and is held: far under the noise of
# any recording, far above that of rounding.
_UNDEFINED = 1e-9

_MIRROR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])  # (arm, xyz): y → -y for the right


def wrap(angle: Array) -> Array:
    """Wrap angles, any shape, rad, into [-π, π)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def posture_from_angles(joint_angles: Array) -> Array:
    """Compute the posture that joint angles give.

    Args:
        joint_angles: Joint angles, shape (..., 8), rad, in the order of `JOINT_NAMES`.

    Returns:
        Posture, shape (..., 12), four unit vectors.
    """
    a, b, c, e = np.moveaxis(joint_angles.reshape(*joint_angles.shape[:-1], 2, 4), -1, 0)
    x_axis, y_axis, upper_arm = _upper_arm_frame(a, b)
    forearm = (
        (np.sin(e) * np.cos(c))[..., None] * x_axis
        + (np.sin(e) * np.sin(c))[..., None] * y_axis
        + np.cos(e)[..., None] * upper_arm
    )
    posture = np.stack([upper_arm, forearm], axis=-2) * _MIRROR[:, None, :]
    return posture.reshape(*joint_angles.shape[:-1], 12)


def angles_from_posture(posture: Array, near: Array | None = None) -> Array:
    """Solve the inverse kinematics in closed form.

    Args:
        posture: Posture, shape (..., 12); each of its four vectors of any length but 0.
        near: Joint angles, shape (..., 8), rad, that the solution has to be close to. Picks
            the branch and the multiple of 2π, and is held where an angle is undefined.
            Without it: the branch of |flexion| ≤ π/2, and 0 for undefined angles.

    Returns:
        Joint angles, shape (..., 8), rad.
    """
    arms = posture.reshape(*posture.shape[:-1], 2, 2, 3) * _MIRROR[:, None, :]
    arms = arms / np.linalg.norm(arms, axis=-1, keepdims=True)
    regular = np.hypot(arms[..., 0, 1], arms[..., 0, 2]) > _UNDEFINED
    abduction = np.arctan2(arms[..., 0, 1], -arms[..., 0, 2])
    if near is None:
        angles, bent = _angles_at_abduction(arms, np.where(regular, abduction, 0.0))
        return np.where(bent, angles, 0.0).reshape(*posture.shape[:-1], 8)
    near = np.broadcast_to(near, (*posture.shape[:-1], 8)).reshape(*arms.shape[:-2], 4)
    way = np.where(regular, wrap(abduction - near[..., 0]), 0.0)
    branches = near[..., 0] + np.stack([way, np.where(regular, way + np.pi, 0.0)])
    angles, bent = _angles_at_abduction(arms, branches)
    steps = np.where(bent, wrap(angles - near), 0.0)  # (branch, ..., 2, 4)
    return (near + _shorter(steps, np.sin(angles[..., 3]))).reshape(*posture.shape[:-1], 8)


def continuous_angles(posture: Array, start: Array | None = None) -> Array:
    """Solve the inverse kinematics of a movement without jumps between branches.

    Args:
        posture: Postures in the order of time, shape (T, 12).
        start: Joint angles, shape (8,), rad, that the first solution has to be close to.

    Returns:
        Joint angles, shape (T, 8), rad: each row on the branch nearest to the row before.
    """
    angles = np.empty((len(posture), 8))
    near = start
    for t, now in enumerate(posture):
        near = angles[t] = angles_from_posture(now, near)
    return angles


def segment_leverage(joint_angles: Array) -> Array:
    """Return how far each joint turns the segment that it is there to turn.

    Near a singular pose a joint may have to turn fast to move its segment hardly at all:
    abduction turns the upper arm by cos(flexion), rotation turns the forearm by sin(elbow).

    Args:
        joint_angles: Joint angles, shape (..., 8), rad.

    Returns:
        Speed of the segment over speed of the joint, shape (..., 8), in [0, 1].
    """
    angles = joint_angles.reshape(*joint_angles.shape[:-1], 2, 4)
    leverage = np.ones_like(angles)
    leverage[..., 0] = np.abs(np.cos(angles[..., 1]))
    leverage[..., 2] = np.abs(np.sin(angles[..., 3]))
    return leverage.reshape(joint_angles.shape)


def _upper_arm_frame(a: Array, b: Array) -> tuple[Array, Array, Array]:
    """Return x axis, y axis and -z axis (= u) of Rx(a) Ry(-b), each (..., 3)."""
    sin_a, cos_a, sin_b, cos_b = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    x_axis = np.stack([cos_b, -sin_a * sin_b, cos_a * sin_b], axis=-1)
    y_axis = np.stack([np.zeros_like(a), cos_a, sin_a], axis=-1)
    upper_arm = np.stack([sin_b, sin_a * cos_b, -cos_a * cos_b], axis=-1)
    return x_axis, y_axis, upper_arm


def _angles_at_abduction(arms: Array, a: Array) -> tuple[Array, Array]:
    """Solve for the other angles, given abduction, which picks the branch.

    Args:
        arms: Mirrored unit vectors, shape (..., 2, 2, 3).
        a: Abduction, shape (..., 2), rad, perhaps with a leading axis of branches.

    Returns:
        Angles, shape (..., 2, 4), and which of them are defined: rotation needs a bent elbow.
    """
    upper_arm, forearm = arms[..., 0, :], arms[..., 1, :]
    in_plane = upper_arm[..., 1] * np.sin(a) - upper_arm[..., 2] * np.cos(a)
    b = np.arctan2(upper_arm[..., 0], in_plane)
    x_axis, y_axis, axis = _upper_arm_frame(a, b)
    g_x = np.sum(forearm * x_axis, axis=-1)
    g_y = np.sum(forearm * y_axis, axis=-1)
    sin_e = np.hypot(g_x, g_y)
    e = np.arctan2(sin_e, np.sum(forearm * axis, axis=-1))
    angles = np.stack([a, b, np.arctan2(g_y, g_x), e], axis=-1)
    return angles, (sin_e > _UNDEFINED)[..., None] | (np.arange(4) != 2)


def _shorter(steps: Array, sin_e: Array) -> Array:
    """Return the shorter of two steps (2, ..., 4); rotation counts as the elbow is bent."""
    length = np.sum(steps**2, axis=-1) - (1.0 - sin_e**2) * steps[..., 2] ** 2
    return np.where((length[0] <= length[1])[..., None], steps[0], steps[1])
