"""Poses that recording and export put before a movement: a T-pose, and a ramp out of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.body import segments

__all__ = ["startup_frames"]

Array = NDArray[np.float64]

_FASTER_THAN_HUMAN = 25.0  # rad/s; dances reach 15 (choice)
_STILL = 0.35  # rad: more than a T-pose sways (choice)
_RAMP = 0.25  # s that a ramp lasts at most (choice)


def startup_frames(points: dict[str, Array], rate: float) -> int:
    """Count the frames before the movement itself.

    Start-up shows by arms that, out of their first pose and within a quarter of a second, turn
    faster than any human arm, and do not come back at once, as a marker does that jumps.

    Args:
        points: The points of `body.ARM_POINTS`, each shape (T, 3), without gaps.
        rate: Frames per second, Hz.

    Returns:
        How many frames to leave out.
    """
    arms = segments(points).values()
    speed = np.max([_angles(arm[1:], arm[:-1]) for arm in arms], axis=0) * rate
    away = np.max([_angles(arm[1:], arm[:1]) for arm in arms], axis=0)  # from the first pose
    moving = np.flatnonzero(away > _STILL)
    if not len(moving):
        return 0
    first = int(moving[0])
    ramp = speed[first : first + max(1, round(_RAMP * rate))]
    fast = np.flatnonzero(ramp > _FASTER_THAN_HUMAN)
    if not len(fast) or len(ramp) == len(speed):
        return 0
    end = first + int(fast[-1]) + 1
    return end if (away[end - 1 : end + 2] > _STILL).all() else 0


def _angles(vectors: Array, others: Array) -> Array:
    """Return the angles between vectors, shape (N, 3), and others, (N, 3) or (1, 3): (N,), rad."""
    lengths = np.linalg.norm(vectors, axis=1) * np.linalg.norm(others, axis=1)
    return np.arccos(np.clip(np.sum(vectors * others, axis=1) / lengths, -1.0, 1.0))
