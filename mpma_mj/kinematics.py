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
    "after_abduction",
    "angles_from_posture",
    "as_left_arms",
    "nearest_step",
    "posture_from_angles",
    "segment_jacobian",
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
_UNDEFINED = np.array(1e-9)

# As arrays, which small arrays are combined with faster than with Python's numbers.
_HALF_TURN, _TURN = np.array(np.pi), np.array(2 * np.pi)

_MIRROR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])  # (arm, xyz): y → -y for the right


def wrap(angle: Array) -> Array:
    """Wrap angles, any shape, rad, into [-π, π)."""
    return (angle + _HALF_TURN) % _TURN - _HALF_TURN


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
            a flexion of at most π/2, and undefined angles are 0.

    Returns:
        Joint angles, shape (..., 8), rad.
    """
    if near is None:
        angles, _, _, sin_e = _one_branch(posture, 0.0)
    else:
        angles, _, sin_e = nearest_step(posture, near)
    angles[2] *= sin_e > _UNDEFINED
    joined = angles.T.reshape(*posture.shape[:-1], 8)
    return joined if near is None else near + joined


def nearest_step(posture: Array, near: Array) -> tuple[Array, Array, Array]:
    """Solve the inverse kinematics for the smallest step that leads to a posture.

    Args:
        posture: Posture, shape (..., 12); its four vectors may have any length but 0.
        near: Joint angles, shape (..., 8), rad, from which the step goes to the nearest branch and
            multiple of 2π.

    Returns:
        The step by angle, arm and posture, shape (4, 2, n), rad, in [-π, π); and cos b and sin e of
        the angles to which it leads, shape (2, n), 0 where abduction and rotation are undefined.
    """
    shape = posture.shape[:-1]
    if near.shape[:-1] != shape:
        near = np.broadcast_to(near, (*shape, 8))
    start = near.reshape(-1, 2, 4).T.copy()  # (4, arm, n)
    angles, regular, cos_b, sin_e = _one_branch(posture, start[0])
    step = wrap(angles - start)
    np.negative(angles[1], out=angles[1])
    angles[:3] += _HALF_TURN
    other_step = wrap(angles - start)
    # The nearer branch, with rotation weighted by the bend of the elbow.
    other = regular & (_length(other_step, sin_e) < _length(step, sin_e))
    return np.where(other, other_step, step), cos_b, sin_e


def as_left_arms(posture: Array) -> Array:
    """Return the directions u and f of each arm as those of left arms, (2, T, 6) of (T, 12)."""
    arms = posture.reshape(-1, 2, 2, 3) * _MIRROR[:, None, :]
    return np.moveaxis(arms, 1, 0).reshape(2, -1, 6)


def segment_jacobian(joint_angles: Array) -> tuple[Array, Array]:
    """Compute the directions of the segments of left arms and their derivatives.

        ∂d/∂q_j = axis_j × d        for a direction d that joint j turns

    Args:
        joint_angles: Joint angles of an arm, shape (T, 4), rad; those of a right arm have the
            mirror image.

    Returns:
        Directions u and f, shape (T, 6), and their derivatives, shape (T, 6, 4).
    """
    a, b, c, e = joint_angles.T
    x_axis, y_axis, upper_arm = _upper_arm_frame(a, b)
    along_x, along_y = np.sin(c)[:, None], np.cos(c)[:, None]
    bend = along_y * x_axis + along_x * y_axis
    forearm = np.sin(e)[:, None] * bend + np.cos(e)[:, None] * upper_arm
    axes = np.stack(
        [
            np.broadcast_to([1.0, 0.0, 0.0], upper_arm.shape),
            -y_axis,
            -upper_arm,
            along_x * x_axis - along_y * y_axis,
        ]
    )
    directions = np.concatenate([upper_arm, forearm], axis=1)
    derivatives = np.zeros((len(a), 6, 4))
    derivatives[:, :3, :2] = np.moveaxis(np.cross(axes[:2], upper_arm), 0, -1)
    derivatives[:, 3:] = np.moveaxis(np.cross(axes, forearm), 0, -1)
    return directions, derivatives


def after_abduction(directions: Array, abduction: Array) -> tuple[Array, Array, Array]:
    """Solve for flexion, rotation and elbow where abduction is given.

    Args:
        directions: Directions u and f of a left arm, shape (..., 6).
        abduction: Abduction, shape (...), rad.

    Returns:
        Flexion with which u is nearest, rotation and elbow, each shape (...), rad.
    """
    upper_arm, forearm = directions[..., :3], directions[..., 3:]
    down = upper_arm[..., 1] * np.sin(abduction) - upper_arm[..., 2] * np.cos(abduction)
    flexion = np.arctan2(upper_arm[..., 0], down)
    x_axis, y_axis, along = _upper_arm_frame(abduction, flexion)
    g_x, g_y = np.vecdot(forearm, x_axis), np.vecdot(forearm, y_axis)
    return flexion, np.arctan2(g_y, g_x), np.arctan2(np.hypot(g_x, g_y), np.vecdot(forearm, along))


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


def _length(step: Array, sin_e: Array) -> Array:
    """Return the squared length of steps, (4, 2, n), without the elbow's, alike on both."""
    a, b, c, _ = step
    return a * a + b * b + (sin_e * c) ** 2


def _one_branch(
    posture: Array, held: Array | float
) -> tuple[Array, NDArray[np.bool_], Array, Array]:
    """Solve for the angles on the branch of |flexion| ≤ π/2.

    Here n counts the postures and comes last, so that each component is an array of its own: numpy
    computes small arrays several times as fast as strides through one.

    Args:
        posture: Posture, shape (..., 12).
        held: Abduction where it is undefined, shape (2, n) or one for all, rad.

    Returns:
        Angles, shape (4, 2, n), rad; whether abduction is defined; cos b, which is 0 where it is
        not; and sin e, which is 0 where rotation is undefined; each of shape (2, n).
    """
    components = posture.reshape(-1, 2, 6).T.copy()  # (6, arm, n)
    components[1::3, 1] *= -1.0  # the right arm is mirrored
    u_x, u_y, u_z, f_x, f_y, f_z = components
    off_x = np.hypot(u_y, u_z)
    length = np.hypot(u_x, off_x)
    sin_b, cos_b = u_x / length, off_x / length
    regular = cos_b > _UNDEFINED
    angles = np.empty((4, *u_x.shape))
    angles[0] = a = np.where(regular, np.arctan2(u_y, -u_z), held)
    angles[1] = np.arctan2(sin_b, cos_b)
    # The forearm after Rx(-a), then after Ry(b): g, as long as f.
    sin_a, cos_a = np.sin(a), np.cos(a)
    g_y = f_y * cos_a + f_z * sin_a
    down = f_y * sin_a - f_z * cos_a
    g_x = f_x * cos_b - down * sin_b
    along = f_x * sin_b + down * cos_b
    across = np.hypot(g_x, g_y)
    angles[2] = np.arctan2(g_y, g_x)
    angles[3] = np.arctan2(across, along)
    sin_e = across / np.hypot(across, along)
    return angles, regular, cos_b, sin_e
