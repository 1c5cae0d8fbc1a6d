"""Dynamic program: the cheapest path of joint angles through candidates for each step.

The cost of a path is

    Σ_t |d(q_t) - d*_t|² + 0.02 (Δq/s)² + 3 max(|Δq|/s - 0.8, 0)²        summed over joints

with s the largest step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["cheapest_path"]

Array = NDArray[np.float64]

# Choices.
_MOVING, _HURRYING, _HURRY = 0.02, 3.0, 0.8  # of the cost
_FARTHEST = 0.3  # squared distance to the directions, above the least, of a candidate


def cheapest_path(angles: Array, distance: Array, step: Array) -> Array:
    """Return the path with the least cost.

    Args:
        angles: Candidates for the joint angles of each step, shape (T, N, n), rad.
        distance: Their squared distance to the directions, shape (T, N); inf excludes one.
        step: Largest change of an angle from one step to the next, shape (n,), rad.

    Returns:
        Joint angles, shape (T, n), rad.
    """
    near = distance <= distance.min(axis=1, keepdims=True) + _FARTHEST
    chosen = np.flatnonzero(near[0])
    cost, places, origins = distance[0, chosen], [chosen], []
    for t in range(1, len(angles)):
        chosen = np.flatnonzero(near[t])
        change = np.abs(angles[t, chosen, None] - angles[t - 1, places[-1]]) / step
        hurry = np.maximum(change - _HURRY, 0.0)
        total = cost + np.sum(_MOVING * change**2 + _HURRYING * hurry**2, axis=-1)
        origins.append(total.argmin(axis=1))
        cost = total.min(axis=1) + distance[t, chosen]
        places.append(chosen)
    best = int(cost.argmin())
    path = [places[-1][best]]
    for place, origin in zip(places[-2::-1], reversed(origins), strict=True):
        best = int(origin[best])
        path.append(place[best])
    return angles[np.arange(len(angles)), path[::-1]]
