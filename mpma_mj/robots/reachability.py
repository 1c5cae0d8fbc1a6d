"""Share of postures that an arm reaches within its joints' ranges."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import posture_from_angles
from mpma_mj.robots.branches import nearest_branch
from mpma_mj.robots.chain import Chain

__all__ = ["MIRRORED", "PROBES", "REACHED", "both_arms", "deviation", "reachable_share"]

Array = NDArray[np.float64]

REACHED = 5.0
"""Deviation of directions up to which a posture counts as reached, degrees."""

MIRRORED = np.array([1.0, -1.0, 1.0] * 2)
"""Factors on directions u and f of a left arm that give those of its mirror image."""

# Angles that people's shoulders and elbows have, degrees, in the order of `JOINT_NAMES` (choice).
_ANGLES = ((0, 45, 90, 135, 180), (-30, 0, 30, 60), (-60, 0, 60), (10, 50, 90, 130))

PROBES: Array = posture_from_angles(
    np.tile(np.radians([*itertools.product(*_ANGLES)], dtype=np.float64), 2)
)[:, :6]
"""Directions u and f of a left arm in postures of people, shape (240, 6)."""


def both_arms() -> Array:
    """Return directions u and f of both arms in mirrored postures of people, shape (240, 12)."""
    return np.hstack([PROBES, PROBES * MIRRORED])


def deviation(chain: Chain, joint_angles: Array, directions: Array) -> Array:
    """Return by how much an arm deviates from directions, by the worse of its two segments.

    Args:
        chain: The arm.
        joint_angles: Joint angles, shape (..., 4), rad.
        directions: Unit vectors u and f, shape (..., 6).

    Returns:
        Angles between directions, shape (...), degrees.
    """
    shown = chain.directions(joint_angles).reshape(*joint_angles.shape[:-1], 2, 3)
    goal = np.broadcast_to(directions.reshape(*directions.shape[:-1], 2, 3), shown.shape)
    sine = np.linalg.norm(np.cross(shown, goal), axis=-1)
    worse: Array = np.degrees(np.arctan2(sine, np.vecdot(shown, goal)).max(axis=-1))
    return worse


def reachable_share(chain: Chain, directions: Array) -> float:
    """Return the share of directions, shape (N, 6), from which an arm deviates by 5° at most."""
    near = np.broadcast_to(np.clip(0.0, chain.lowest, chain.highest), (len(directions), 4))
    reached = nearest_branch(chain, directions, near)
    return float(np.mean(deviation(chain, reached, directions) <= REACHED))
