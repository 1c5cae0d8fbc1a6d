"""Inverse kinematics of a chain in closed form: up to four branches.

The angle between u and f fixes the elbow, and with it the rotation of the third link, R; the angle
between the first axis and R a_3 fixes the second joint. Both are one problem of two solutions, a
`circle`; first and third angle follow. A circle has no solution where the arm does not reach.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.chain import Chain
from mpma_mj.robots.nearest_posture import nearest_posture
from mpma_mj.robots.rotations import about, across, between, circle, frame, rotated

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
    bend = between(upper_arm, forearm)
    straight = np.sin(bend) < _UNDEFINED
    held_third = held[..., 2, None]

    elbow = circle(fourth, chain.forearm, chain.upper_arm, bend)  # (..., 2)
    own = frame(chain.upper_arm, rotated(chain.forearm, fourth, elbow))
    link = frame(upper_arm, forearm)[..., None, :, :] @ np.swapaxes(own, -1, -2)  # R
    # The vector of the third link that the first two joints bring to its place: its axis, or, with
    # the third angle held, the upper arm.
    moved = np.where(
        straight[..., None, None], rotated(chain.upper_arm, third, held_third), third
    )  # (..., 1, 3)
    place = np.where(straight[..., None, None], upper_arm[..., None, :], link @ third)
    flexion = circle(second, moved, first, between(first, place))  # (..., 2, 2)
    moved = rotated(moved[..., None, :], second, flexion)
    abduction = about(first, moved, place[..., None, :])
    undefined = np.linalg.norm(np.cross(first, moved), axis=-1) < _UNDEFINED
    abduction = np.where(undefined, held[..., 0, None, None], abduction)
    aside = across(third)
    seen = rotated((link @ aside)[..., None, :], first, -abduction)
    rotation = about(third, aside, rotated(seen, second, -flexion))
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
