"""Dynamic program: the cheapest path of joint angles through candidates for each step.

The cost of a path is

    Σ_t |d(q_t) - d*_t|² + moving (Δq/s)² + hurrying max(|Δq|/s - hurry, 0)²    summed over joints

with s the largest step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["PathCost", "cheapest_cycle", "cheapest_path"]

Array = NDArray[np.float64]


class PathCost(NamedTuple):
    """Weights of the cost, and which candidates take part (choices).

    Attributes:
        moving: Weight of squared steps.
        hurrying: Weight of squared steps beyond `hurry`.
        hurry: Share of the largest step.
        farthest: Squared distance to the directions, above the least, of a candidate.
    """

    moving: float = 0.02
    hurrying: float = 3.0
    hurry: float = 0.8
    farthest: float = 0.3


def cheapest_path(
    angles: Array, distance: Array, step: Array, cost: PathCost | None = None
) -> Array:
    """Return the path with the least cost.

    Args:
        angles: Candidates for the joint angles of each step, shape (T, N, n), rad.
        distance: Their squared distance to the directions, shape (T, N); inf excludes one.
        step: Largest change of an angle from one step to the next, shape (n,), rad.
        cost: The cost.

    Returns:
        Joint angles, shape (T, n), rad.
    """
    places = _places(angles, distance, step, cost or PathCost())
    return angles[np.arange(len(angles)), places]


def cheapest_cycle(
    angles: Array, distance: Array, step: Array, cost: PathCost | None = None
) -> Array:
    """Return a path with the least cost, of those whose end leads into their start.

    It is a stretch of the cheapest path through three repetitions of the candidates, between two
    places that are the same; the middle one where there are none.

    Args:
        angles: Candidates for the joint angles of each step, shape (T, N, n), rad.
        distance: Their squared distance to the directions, shape (T, N); inf excludes one.
        step: Largest change of an angle from one step to the next, shape (n,), rad.
        cost: The cost.

    Returns:
        Joint angles, shape (T, n), rad.
    """
    frames = len(angles)
    places = np.array(
        _places(
            np.concatenate([angles] * 3),
            np.concatenate([distance] * 3),
            step,
            cost or PathCost(),
        )
    )
    same = np.flatnonzero(places[:-frames] == places[frames:])
    first = int(same[np.argmin(np.abs(same - frames))]) if len(same) else frames
    own = np.roll(places[first : first + frames], first)
    return angles[np.arange(frames), own]


def _places(angles: Array, distance: Array, step: Array, cost: PathCost) -> list[int]:
    """Return the index of the cheapest path's candidate in each step."""
    near = distance <= distance.min(axis=1, keepdims=True) + cost.farthest
    chosen = np.flatnonzero(near[0])
    total, places, origins = distance[0, chosen], [chosen], []
    for t in range(1, len(angles)):
        chosen = np.flatnonzero(near[t])
        change = np.abs(angles[t, chosen, None] - angles[t - 1, places[-1]]) / step
        hurry = np.maximum(change - cost.hurry, 0.0)
        way = total + np.sum(cost.moving * change**2 + cost.hurrying * hurry**2, axis=-1)
        origins.append(way.argmin(axis=1))
        total = way.min(axis=1) + distance[t, chosen]
        places.append(chosen)
    best = int(total.argmin())
    path = [int(places[-1][best])]
    for place, origin in zip(places[-2::-1], reversed(origins), strict=True):
        best = int(origin[best])
        path.append(int(place[best]))
    return path[::-1]
