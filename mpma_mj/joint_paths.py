"""Joint angles over time: without jumps between branches, and held where they are not seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import (
    after_abduction,
    angles_from_posture,
    as_left_arms,
    segment_leverage,
    wrap,
)

__all__ = [
    "angles_seen",
    "continuation",
    "continuous_angles",
    "held_angles",
    "nearest_turn",
    "unwound",
]

Array = NDArray[np.float64]

# Below this sine or cosine an angle cannot be seen in a recording: 3°, the noise of markers
# (choice).
_UNSEEN = 0.05


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


def held_angles(posture: Array) -> Array:
    """Solve the inverse kinematics of a motion, and hold the angles that cannot be seen.

    Within 3° of a singular posture noise turns abduction or rotation by whole turns. There the
    angle goes evenly from its last seen value to the next, and the others follow it; a segment
    moves by less than 6°. Where an abduction is first seen, its flexion is at most π/2.

    Args:
        posture: Postures over time, shape (T, 12).

    Returns:
        Joint angles, shape (T, 8), rad; those of `continuous_angles` where all angles are seen.
    """
    angles, seen = np.empty((len(posture), 8)), np.ones((len(posture), 8), bool)
    near = _first_seen(posture)
    for t, now in enumerate(posture):
        angles[t] = angles_from_posture(now, near)
        seen[t] = angles_seen(angles[t])
        near = angles[t] if seen[t].all() else np.where(seen[t], angles[t], near)
    for arm, held in enumerate(np.moveaxis(seen.reshape(-1, 2, 4), 1, 0)):
        abduction, flexion, rotation, elbow = angles[:, 4 * arm : 4 * arm + 4].T  # views
        if not held[:, 0].all():
            _interpolate(abduction, held[:, 0])
            own = as_left_arms(posture)[arm]
            for angle, solved in zip(
                (flexion, rotation, elbow), after_abduction(own, abduction), strict=True
            ):
                hidden = ~held[:, 0]
                angle[hidden] += wrap(solved - angle)[hidden]
        if not held[:, 2].all():
            _interpolate(rotation, held[:, 2])
    return angles


def angles_seen(joint_angles: Array) -> NDArray[np.bool_]:
    """Return which joint angles, shape (..., 8), rad, are seen in a posture: (..., 8).

    Within 3° of a singular posture an angle cannot be distinguished from noise.
    """
    return segment_leverage(joint_angles) > _UNSEEN


def nearest_turn(joint_angles: Array, near: Array) -> Array:
    """Return the smallest step to joint angles, or to others that hold the same posture.

    Args:
        joint_angles: Joint angles, shape (..., 8), rad.
        near: Joint angles from which the step goes, shape (..., 8), rad.

    Returns:
        The step, shape (..., 8), rad, in [-π, π), on the branch on which it is shorter.
    """
    step = wrap(joint_angles - near)
    other = joint_angles + np.pi
    other[..., 1::4] -= 2.0 * joint_angles[..., 1::4]
    other[..., 3::4] = joint_angles[..., 3::4]
    other = wrap(other - near)
    arms = (*step.shape[:-1], 2, 4)
    step, other = step.reshape(arms), other.reshape(arms)
    shorter = np.vecdot(other, other) < np.vecdot(step, step)
    return np.where(shorter[..., None], other, step).reshape(near.shape)


def continuation(joint_angles: Array, near: Array) -> tuple[Array, Array]:
    """Return how joint angles become those of the same posture that are nearest to others.

    Args:
        joint_angles: Joint angles q, shape (8,), rad.
        near: Joint angles to which they should be near, shape (8,), rad.

    Returns:
        Sign and offset, each shape (8,), of sign · q + offset: whole turns, and the other branch,
        (a+π, π-b, c+π, e), where that is nearer.
    """
    nearest = near + nearest_turn(joint_angles, near)
    other_branch = np.abs(wrap(nearest - joint_angles)[0::4]) > 0.5 * np.pi
    sign = np.ones(8)
    sign[1::4] = np.where(other_branch, -1.0, 1.0)
    return sign, np.round((nearest - sign * joint_angles) / np.pi) * np.pi


def unwound(joint_angles: Array) -> Array:
    """Return a path of joint angles without the whole turns that can be left out.

    Args:
        joint_angles: Joint angles over time, shape (T, n), rad.

    Returns:
        Joint angles, shape (T, n), rad, less a number of turns for each joint, after which the
        middle of its range is within half a turn of 0.
    """
    middle = 0.5 * (joint_angles.min(axis=0) + joint_angles.max(axis=0))
    return joint_angles - 2.0 * np.pi * np.round(middle / (2.0 * np.pi))


def _first_seen(posture: Array) -> Array:
    """Return each arm's joint angles, together (8,), rad, where its abduction is first seen."""
    angles = angles_from_posture(posture)
    first = np.argmax(angles_seen(angles)[:, 0::4], axis=0)
    return angles[np.repeat(first, 4), np.arange(8)]


def _interpolate(angle: Array, seen: NDArray[np.bool_]) -> None:
    """Replace the unseen values of an angle over time, shape (T,), rad, in place."""
    times = np.arange(len(angle))
    if not seen.any():
        angle[:] = 0.0
    else:
        angle[:] = np.interp(times, times[seen], angle[seen])
