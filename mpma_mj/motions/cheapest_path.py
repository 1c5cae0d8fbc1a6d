"""Dynamic program: the cheapest path of joint angles through candidates for each step.

The cost of a path is

    Σ_t |d(q_t) - d*_t|² + speed_weight (Δq/s)² + excess_weight max(|Δq|/s - excess_from, 0)²

summed over joints, with s the largest step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import wrap

__all__ = ["PathCost", "cheapest_cycle", "cheapest_path"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class PathCost(NamedTuple):
    """Weights of the cost, and which candidates take part (choices).

    Attributes:
        speed_weight: Weight of squared steps.
        excess_weight: Weight of squared steps beyond `excess_from`.
        excess_from: Share of the largest step.
        farthest: Squared distance to the directions, above the least, of a candidate.
    """

    speed_weight: float = 0.02
    excess_weight: float = 3.0
    excess_from: float = 0.8
    farthest: float = 0.3


def cheapest_path(
    angles: Array,
    distance: Array,
    step: Array,
    cost: PathCost | None = None,
    endless: Mask | None = None,
) -> Array:
    """Return the path with the least cost.

    Args:
        angles: Candidates for the joint angles of each step, shape (T, N, n), rad.
        distance: Their squared distance to the directions, shape (T, N); inf excludes one.
        step: Largest change of an angle from one step to the next, shape (n,), rad.
        cost: The cost.
        endless: Which joints may make whole turns, shape (n,); none if not given.

    Returns:
        Joint angles, shape (T, n), rad.
    """
    places = _places(angles, distance, step, cost or PathCost(), endless)
    return _path(angles, places, endless)


def cheapest_cycle(
    angles: Array,
    distance: Array,
    step: Array,
    cost: PathCost | None = None,
    endless: Mask | None = None,
) -> Array:
    """Return a path with the least cost, of those whose end leads into their start.

    It is a stretch of the cheapest path through three repetitions of the candidates, between two
    places that are the same; the middle one where there are none. Arguments and result are those of
    `cheapest_path`.
    """
    frames = len(angles)
    thrice = np.concatenate([angles] * 3), np.concatenate([distance] * 3)
    places = _places(*thrice, step, cost or PathCost(), endless)
    same = np.flatnonzero(places[:-frames] == places[frames:])
    first = int(same[np.argmin(np.abs(same - frames))]) if len(same) else frames
    return _path(angles, np.roll(places[first : first + frames], first), endless)


def _path(angles: Array, places: NDArray[np.intp], endless: Mask | None) -> Array:
    """Return the candidates at places, without the jumps of joints that may make whole turns."""
    path: Array = angles[np.arange(len(angles)), places]
    if endless is not None:
        path[:, endless] = np.unwrap(path[:, endless], axis=0)
    return path


def _places(
    angles: Array, distance: Array, step: Array, cost: PathCost, endless: Mask | None
) -> NDArray[np.intp]:
    """Return the index of the cheapest path's candidate in each step."""
    near = distance <= distance.min(axis=1, keepdims=True) + cost.farthest
    chosen = np.flatnonzero(near[0])
    total, places, origins = distance[0, chosen], [chosen], []
    for t in range(1, len(angles)):
        chosen = np.flatnonzero(near[t])
        turn = angles[t, chosen, None] - angles[t - 1, places[-1]]
        if endless is not None:
            turn[..., endless] = wrap(turn[..., endless])
        change = np.abs(turn) / step
        excess = np.maximum(change - cost.excess_from, 0.0)
        way = total + np.sum(
            cost.speed_weight * change**2 + cost.excess_weight * excess**2, axis=-1
        )
        origins.append(way.argmin(axis=1))
        total = way.min(axis=1) + distance[t, chosen]
        places.append(chosen)
    best = int(total.argmin())
    path = [places[-1][best]]
    for place, origin in zip(places[-2::-1], reversed(origins), strict=True):
        best = int(origin[best])
        path.append(place[best])
    return np.array(path[::-1])
