"""Forward and inverse kinematics of two arms with four degrees of freedom each.

A posture consists of the unit vectors shoulder→elbow `u` and elbow→wrist `f` of each arm, in the
torso frame (x forward, y left, z up). At zero angles an arm hangs along -z. With abduction a,
flexion b, rotation c and elbow flexion e, the left arm is

    R = Rx(a) Ry(-b) Rz(c)        u = R (0, 0, -1)        f = R Ry(-e) (0, 0, -1)

and the right arm is its mirror image (y → -y), so that equal angles give mirrored postures.
Abduction raises the arm sideways, flexion raises it forward, positive rotation is outward,
elbow flexion brings the forearm forward. Written out,

    u = (sin b, sin a cos b, -cos a cos b)
    g = (Rx(a) Ry(-b))ᵀ f = (sin e cos c, sin e sin c, -cos e)

which is inverted in closed form. Every posture has two solutions, (a, b, c, e) and
(a+π, π-b, c+π, e), each modulo 2π: the *branches*. Two kinds of posture are singular: an upper
arm straight forward or back (cos b = 0, a undefined) and a straight elbow (sin e = 0, c
undefined). With this order of axes hanging and overhead arms, which are frequent, are regular.
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

# Below this sine or cosine an angle counts as undefined and is held: far below the noise of any
# recording, far above rounding errors.
_UNDEFINED = 1e-9

# The other branch of angles (a, b, c, e) is (a, -b, c, e) + (π, π, π, 0).
_FLIP, _HALF_TURN = np.array([1.0, -1.0, 1.0, 1.0]), np.array([np.pi, np.pi, np.pi, 0.0])

_MIRROR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])  # (arm, xyz): y → -y for the right


def wrap(angle: Array) -> Array:
    """Wrap angles, any shape, rad, into [-π, π)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def posture_from_angles(joint_angles: Array) -> Array:
    """Compute the posture from joint angles.

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
        posture: Posture, shape (..., 12); its four vectors may have any length but 0.
        near: Joint angles, shape (..., 8), rad, which select the nearest branch and multiple of
            2π, and replace undefined angles. Without them the solution is on the branch of
            |flexion| ≤ π/2, and undefined angles are 0.

    Returns:
        Joint angles, shape (..., 8), rad.
    """
    shape = posture.shape[:-1]
    arms = posture.reshape(*shape, 2, 2, 3) * _MIRROR[:, None, :]
    arms /= np.sqrt(np.vecdot(arms, arms))[..., None]
    if near is None:
        angles, _, sin_e = _one_branch(arms, np.zeros((*shape, 2)))
        angles[..., 2] *= sin_e > _UNDEFINED
        return angles.reshape(*shape, 8)
    near = np.broadcast_to(near, (*shape, 8)).reshape(*shape, 2, 4)
    angles, regular, sin_e = _one_branch(arms, near[..., 0])
    steps = wrap(np.stack([angles, angles * _FLIP + _HALF_TURN]) - near)  # (branch, ..., 2, 4)
    steps[..., 2] *= sin_e > _UNDEFINED
    # The nearer branch, with rotation weighted by the bend of the elbow.
    length = np.vecdot(steps, steps) - (1.0 - sin_e**2) * steps[..., 2] ** 2
    other = regular & (length[1] < length[0])
    return (near + np.where(other[..., None], steps[1], steps[0])).reshape(*shape, 8)


def continuous_angles(posture: Array, start: Array | None = None) -> Array:
    """Solve the inverse kinematics of a motion without jumps between branches.

    Args:
        posture: Postures over time, shape (T, 12).
        start: Joint angles, shape (8,), rad, which select the branch of the first solution.

    Returns:
        Joint angles, shape (T, 8), rad; each row is on the branch nearest to the previous row.
    """
    angles = np.empty((len(posture), 8))
    near = start
    for t, now in enumerate(posture):
        near = angles[t] = angles_from_posture(now, near)
    return angles


def segment_leverage(joint_angles: Array) -> Array:
    """Return the ratio of a segment's speed to the speed of the joint that moves it.

    Near a singular posture a fast joint hardly moves its segment: the ratio is cos(flexion) for
    abduction and the upper arm, sin(elbow) for rotation and the forearm, and 1 for the others.

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


def _one_branch(arms: Array, held: Array) -> tuple[Array, NDArray[np.bool_], Array]:
    """Solve for the angles on the branch of |flexion| ≤ π/2.

    Args:
        arms: Mirrored unit vectors, shape (..., 2, 2, 3).
        held: Abduction where it is undefined, shape (..., 2), rad.

    Returns:
        Angles, shape (..., 2, 4), rad; whether abduction is defined, shape (..., 2); and sin e,
        shape (..., 2), which is 0 where rotation is undefined.
    """
    upper_arm, forearm = arms[..., 0, :], arms[..., 1, :]
    u_x, u_y, u_z = upper_arm[..., 0], upper_arm[..., 1], upper_arm[..., 2]
    f_x, f_y, f_z = forearm[..., 0], forearm[..., 1], forearm[..., 2]
    regular = np.hypot(u_y, u_z) > _UNDEFINED
    a = np.where(regular, np.arctan2(u_y, -u_z), held)
    sin_a, cos_a = np.sin(a), np.cos(a)
    cos_b = u_y * sin_a - u_z * cos_a
    g_x = f_x * cos_b + u_x * (f_z * cos_a - f_y * sin_a)
    g_y = f_y * cos_a + f_z * sin_a
    sin_e = np.hypot(g_x, g_y)
    angles = np.empty((*a.shape, 4))
    angles[..., 0] = a
    angles[..., 1] = np.arctan2(u_x, cos_b)
    angles[..., 2] = np.arctan2(g_y, g_x)
    angles[..., 3] = np.arctan2(sin_e, np.vecdot(upper_arm, forearm))
    return angles, regular, sin_e
