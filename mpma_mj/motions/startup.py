"""Poses that recording and export put before a movement: a T-pose, and a ramp out of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.body import segments

__all__ = ["startup_frames"]

Array = NDArray[np.float64]

_FASTER_THAN_HUMAN = 25.0  # rad/s; dances reach 15 (choice)
_STILL = 0.3  # rad/s
_RAMP = 0.25  # s that a ramp lasts at most (choice)


def startup_frames(points: dict[str, Array], rate: float) -> int:
    """Count the frames before the movement itself.

    Start-up shows by arms that, out of stillness and within a quarter of a second, turn faster
    than any human arm.

    Args:
        points: The points of `body.ARM_POINTS`, each shape (T, 3), without gaps.
        rate: Frames per second, Hz.

    Returns:
        How many frames to leave out.
    """
    speed = np.max([_speeds(vectors, rate) for vectors in segments(points).values()], axis=0)
    moving = np.flatnonzero(speed > _STILL)
    if not len(moving):
        return 0
    first = int(moving[0])
    ramp = speed[first : first + max(1, round(_RAMP * rate))]
    fast = np.flatnonzero(ramp > _FASTER_THAN_HUMAN)
    if not len(fast) or len(ramp) == len(speed):
        return 0
    return first + int(fast[-1]) + 1


def _speeds(vectors: Array, rate: float) -> Array:
    """Return how fast a segment turns from each frame to the next, shape (T-1,), rad/s."""
    unit = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    cosine = np.sum(unit[1:] * unit[:-1], axis=1)
    return np.arccos(np.clip(cosine, -1.0, 1.0)) * rate
