"""Plain poses, in which faults of a robot's description are seen at a glance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.branches import nearest_branch
from mpma_mj.robots.chain import Chain

__all__ = ["POSES", "pose_angles", "pose_directions"]

Array = NDArray[np.float64]

POSES: dict[str, tuple[float, float, float]] = {
    "T-pose": (0.0, 1.0, 0.0),
    "arms down": (0.0, 0.0, -1.0),
    "arms up": (0.0, 0.0, 1.0),
    "arms forward": (1.0, 0.0, 0.0),
}
"""Direction of the straight left arm, x forward, y left, z up; the right arm mirrors it."""


def pose_directions(pose: str) -> Array:
    """Return the directions u and f of both arms in one of `POSES`, shape (2, 6)."""
    x, y, z = POSES[pose]
    return np.array([[x, y, z] * 2, [x, -y, z] * 2])


def pose_angles(chains: Sequence[Chain], pose: str) -> Array:
    """Return the joint angles of a pose, or the nearest that are reachable, shape (8,), rad.

    Args:
        chains: The left and the right arm.
        pose: One of `POSES`.
    """
    return np.concatenate(
        [
            nearest_branch(
                chain, goal[None], np.clip(np.zeros((1, 4)), chain.lowest, chain.highest)
            )
            for chain, goal in zip(chains, pose_directions(pose), strict=True)
        ],
        axis=1,
    )[0]
