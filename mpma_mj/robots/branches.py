"""Inverse kinematics of a chain in closed form: up to four branches.

The angle between u and f fixes the elbow, and with it the rotation of the third link, R; the angle
between the first axis and R a_3 fixes the second joint. Both are one problem, a *circle*: the angle
x about an axis at which a vector has a given angle θ to a fixed vector. With α and β the angles
of both vectors to the axis, and s = (α + β + θ) / 2,

    tan²(φ/2) = sin(s - α) sin(s - β) / (sin s sin(s - θ))        x = x_0 ± φ

(the half-angle formula of spherical trigonometry, exact also near φ = 0), with x_0 at which both
vectors are on the same side of the axis. First and third angle follow. Two circles of two
solutions each are four branches; a circle has none where the arm does not reach θ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.chain import Chain, rotated
from mpma_mj.robots.nearest_posture import nearest_posture

__all__ = ["Branches", "branches", "nearest_branch", "nearest_turns"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_HOLDS = 1e-9  # deviation of directions up to which angles hold them
_UNDEFINED = 1e-10  # sine below which an angle is undefined; holding it deviates by as much
_WITHIN = 1e-9  # rad, by which rounding may put angles beyond a range
_TURN = 2.0 * np.pi


class Branches(NamedTuple):
    """Solutions of the inverse kinematics.

    Attributes:
        angles: Joint angles of the four branches, shape (..., 4, 4), rad; two are equal where a
            circle has one solution only.
        exist: Whether the angles hold the directions, shape (..., 4).
        within: Whether the angles are within the joints' ranges, shape (..., 4).
    """

    angles: Array
    exist: Mask
    within: Mask

    @property
    def fit(self) -> Mask:
        """Whether a branch both exists and is within the ranges, shape (..., 4)."""
        return self.exist & self.within


def branches(chain: Chain, directions: Array, near: Array | None = None) -> Branches:
    """Solve the inverse kinematics in closed form.

    Args:
        chain: The arm.
        directions: Directions u and f, shape (..., 6), of any length but 0.
        near: Joint angles, shape (..., 4), rad, which select the whole turns within the ranges and
            replace what is undefined: the third angle of a straight elbow, and the first where the
            third axis points along the first. Without them they are 0.
    """
    goal = directions.reshape(*directions.shape[:-1], 2, 3)
    goal = goal / np.linalg.norm(goal, axis=-1, keepdims=True)
    upper_arm, forearm = goal[..., 0, :], goal[..., 1, :]
    held = np.broadcast_to(0.0 if near is None else near, (*upper_arm.shape[:-1], 4))
    first, second, third, fourth = chain.axes
    bend = _between(upper_arm, forearm)
    straight = np.sin(bend) < _UNDEFINED
    held_third = held[..., 2, None]

    elbow = _circle(fourth, chain.forearm, chain.upper_arm, bend)  # (..., 2)
    own = _frame(chain.upper_arm, rotated(chain.forearm, fourth, elbow))
    link = _frame(upper_arm, forearm)[..., None, :, :] @ np.swapaxes(own, -1, -2)  # R
    # The vector of the third link that the first two joints bring to its place: its axis, or, with
    # the third angle held, the upper arm.
    moved = np.where(
        straight[..., None, None], rotated(chain.upper_arm, third, held_third), third
    )  # (..., 1, 3)
    place = np.where(straight[..., None, None], upper_arm[..., None, :], link @ third)
    flexion = _circle(second, moved, first, _between(first, place))  # (..., 2, 2)
    moved = rotated(moved[..., None, :], second, flexion)
    abduction = _about(first, moved, place[..., None, :])
    undefined = np.linalg.norm(np.cross(first, moved), axis=-1) < _UNDEFINED
    abduction = np.where(undefined, held[..., 0, None, None], abduction)
    across = _across(third)
    seen = rotated((link @ across)[..., None, :], first, -abduction)
    rotation = _about(third, across, rotated(seen, second, -flexion))
    rotation = np.where(straight[..., None, None], held_third[..., None], rotation)

    angles = np.stack(
        [abduction, flexion, rotation, np.broadcast_to(elbow[..., None], flexion.shape)], axis=-1
    ).reshape(*upper_arm.shape[:-1], 4, 4)
    angles = nearest_turns(chain, angles, held[..., None, :])
    deviation = chain.directions(angles) - goal.reshape(directions.shape)[..., None, :]
    within = (angles >= chain.lowest - _WITHIN) & (angles <= chain.highest + _WITHIN)
    return Branches(angles, np.abs(deviation).max(axis=-1) <= _HOLDS, np.all(within, axis=-1))


def nearest_branch(chain: Chain, directions: Array, near: Array) -> Array:
    """Return the joint angles that hold directions, or come nearest to them, within the ranges.

    Args:
        chain: The arm.
        directions: Directions u and f, shape (N, 6), of any length but 0.
        near: Joint angles, shape (N, 4), rad, which select the branch.

    Returns:
        Joint angles, shape (N, 4), rad: of the branch that fits and is nearest; where none fits,
        those of the nearest posture that is found from the branches and from `near`.
    """
    found = branches(chain, directions, near)
    step = np.sum((found.angles - near[:, None]) ** 2, axis=-1)
    best = np.argmin(np.where(found.fit, step, np.inf), axis=-1)
    angles = found.angles[np.arange(len(best)), best]
    none = ~found.fit.any(axis=-1)
    if none.any():
        starts = np.concatenate([near[none, None], found.angles[none]], axis=1)
        goal = np.broadcast_to(directions[none, None], (*starts.shape[:-1], 6))
        reached, distance = nearest_posture(chain, goal, starts)
        best = np.argmin(distance, axis=-1)
        angles[none] = reached[np.arange(len(best)), best]
    return np.clip(angles, chain.lowest, chain.highest)


def nearest_turns(chain: Chain, angles: Array, near: Array | float = 0.0) -> Array:
    """Add whole turns to joint angles, so that they are within the ranges where possible.

    Args:
        chain: The arm.
        angles: Joint angles, shape (..., 4), rad.
        near: Joint angles, shape (..., 4), rad, to which they are nearest then.

    Returns:
        Joint angles, shape (..., 4), rad; nearest to its range where an angle fits into it with no
        turn.
    """
    near = np.clip(near, chain.lowest, chain.highest)
    angles = near + (angles - near + np.pi) % _TURN - np.pi
    other = angles - np.copysign(_TURN, angles - near)  # on the other side
    beyond, beyond_other = (
        np.maximum(chain.lowest - one, one - chain.highest).clip(_WITHIN) for one in (angles, other)
    )
    return np.where(beyond_other < beyond, other, angles)


def _circle(axis: Array, moved: Array, fixed: Array, between: Array) -> Array:
    """Return both angles about an axis at which a vector has an angle to a fixed one.

    Args:
        axis: The axis, shape (3,).
        moved: The vector that turns, shape (..., 3).
        fixed: The fixed vector, shape (3,).
        between: The angle θ, shape (...), rad; where it is not reached, the nearest is.

    Returns:
        Angles, shape (..., 2), rad.
    """
    alpha, beta = _between(axis, fixed), _between(axis, moved)
    s = 0.5 * (alpha + beta + between)
    near = np.sqrt(np.maximum(np.sin(s - alpha) * np.sin(s - beta), 0.0))
    far = np.sqrt(np.maximum(np.sin(s) * np.sin(s - between), 0.0))
    half = 2.0 * np.arctan2(near, far)
    same_side = _about(axis, moved, fixed)
    return np.stack([same_side + half, same_side - half], axis=-1)


def _about(axis: Array, vector: Array, goal: Array) -> Array:
    """Return the angle about an axis that brings vectors nearest to others, (...), rad."""
    across = np.cross(axis, vector)
    return np.arctan2(np.vecdot(goal, across), np.vecdot(goal, np.cross(across, axis)))


def _between(one: Array, other: Array) -> Array:
    """Return the angle between vectors, shape (...), rad; exact also near 0 and π."""
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), np.vecdot(one, other))


def _frame(upper_arm: Array, forearm: Array) -> Array:
    """Return u, the unit vector across it towards f, and their cross product, in columns."""
    upper_arm, forearm = np.broadcast_arrays(upper_arm, forearm)
    normal = np.cross(upper_arm, forearm)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = np.where(
        length > 0.0, normal / np.where(length > 0.0, length, 1.0), _across(upper_arm)
    )
    return np.stack([upper_arm, np.cross(normal, upper_arm), normal], axis=-1)


def _across(vector: Array) -> Array:
    """Return a unit vector across each unit vector, shape (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(vector), axis=-1)]
    normal = np.cross(vector, least)
    return normal / np.linalg.norm(normal, axis=-1, keepdims=True)
