"""Search for joint angles of a chain over a whole motion: starts of a fit.

Candidates for each step are the exact branches, the nearest postures of branches beyond the joints'
ranges, and postures with the first or the third joint on a grid, as these may be nearly free; each
with the whole turns that lie within the ranges. Paths through them: the nearest from step to step,
and the cheapest of dynamic programs.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.cheapest_path import PathCost, cheapest_cycle, cheapest_path
from mpma_mj.motions.joint_fit import StepLimits
from mpma_mj.robots.branches import branches, nearest_turns
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.held_joint import with_first, with_third
from mpma_mj.robots.nearest_posture import nearest_posture

__all__ = ["best_of_paths", "starting_paths"]

Array = NDArray[np.float64]

# Choices.
_FIRST, _THIRD = 32, 16  # angles of the grids
_MOST = 128  # candidates of a step
_STEPS = 20  # of the search for a nearest posture
_UNLIMITED = 4.0  # rad: range of joints without one, more than a turn
_APART = 0.1  # s between the steps of the coarse program
_CLOSE = 100.0  # weight of squared distance beside squared steps, rad², on the nearest path

# Moving little, or as little as needed: either may lead to the better fit.
_LITTLE, _NEEDED = PathCost(), PathCost(moving=0.002, hurry=1.0)
_MIXED = PathCost(moving=1e-4, hurrying=100.0, hurry=1.0, farthest=np.inf)  # as of the fit


def starting_paths(
    directions: Array, chain: Chain, limits: StepLimits, rate: float, cyclic: bool
) -> list[Array]:
    """Return paths of joint angles from which a fit may start.

    Args:
        directions: Directions u and f, shape (T, 6).
        chain: The arm.
        limits: Limits of its joints.
        rate: Steps per second, Hz.
        cyclic: Whether the end leads into the start.

    Returns:
        Joint angles, each shape (T, 4), rad, within the ranges.
    """
    cheapest = cheapest_cycle if cyclic else cheapest_path
    exact = _within(chain, _exact(chain, directions))
    distance = _distance(chain, exact, directions)
    every = max(1, round(_APART * rate))
    known = np.arange(0, len(directions), every)
    grid, grid_distance = _nearest_of(
        np.concatenate([exact, _within(chain, _grids(chain, directions))], axis=1),
        chain,
        directions,
    )
    coarse = cheapest(grid[known], grid_distance[known], every * limits.step, _NEEDED)
    return [
        _nearest_path(exact, distance),
        cheapest(exact, distance, limits.step, _LITTLE),
        cheapest(grid, grid_distance, limits.step, _LITTLE),
        cheapest(grid, grid_distance, limits.step, _NEEDED),
        _between(coarse, known, len(directions), cyclic),
    ]


def best_of_paths(
    paths: list[Array], directions: Array, chain: Chain, limits: StepLimits, cyclic: bool
) -> Array:
    """Return the cheapest path, shape (T, 4), that changes between paths, each shape (T, 4)."""
    angles = np.stack(paths, axis=1)
    cheapest = cheapest_cycle if cyclic else cheapest_path
    return cheapest(angles, _distance(chain, angles, directions), limits.step, _MIXED)


def _exact(chain: Chain, directions: Array) -> Array:
    """Return the branches, or the nearest postures of those that do not fit, (T, 4, 4), rad."""
    found = branches(chain, directions)
    angles, beyond = found.angles, ~found.fit
    goal = np.broadcast_to(directions[:, None], (*beyond.shape, 6))
    angles[beyond], _ = nearest_posture(chain, goal[beyond], angles[beyond], _STEPS)
    return angles


def _grids(chain: Chain, directions: Array) -> Array:
    """Return postures with first or third joint on a grid, shape (T, N, 4), rad."""
    found = []
    for joint, count, held in ((0, _FIRST, with_first), (2, _THIRD, with_third)):
        low, high = np.maximum(chain.lowest[joint], -np.pi), np.minimum(chain.highest[joint], np.pi)
        grid = np.broadcast_to(np.linspace(low, high, count), (len(directions), count))
        goal = np.broadcast_to(directions[:, None], (*grid.shape, 6))
        found.append(held(chain, goal, grid).reshape(len(directions), -1, 4))
    return np.concatenate(found, axis=1)


def _within(chain: Chain, angles: Array) -> Array:
    """Return angles, (T, N, 4), with all turns that lie within the ranges, clipped to these."""
    lowest, highest = np.maximum(chain.lowest, -_UNLIMITED), np.minimum(chain.highest, _UNLIMITED)
    near = nearest_turns(chain, angles)
    wide = np.flatnonzero(highest - lowest > 2.0 * np.pi)
    found = []
    for turned in itertools.product((0.0, 1.0), repeat=len(wide)):
        other = near.copy()
        other[..., wide] -= np.copysign(2.0 * np.pi, other[..., wide]) * turned
        found.append(np.clip(other, lowest, highest))
    return np.concatenate(found, axis=1)


def _distance(chain: Chain, angles: Array, directions: Array) -> Array:
    """Return the squared distance of candidates, (T, N, 4), to directions, shape (T, N)."""
    return np.sum((chain.directions(angles) - directions[:, None]) ** 2, axis=-1)


def _nearest_of(angles: Array, chain: Chain, directions: Array) -> tuple[Array, Array]:
    """Return the candidates that are nearest to the directions, and their distance."""
    distance = _distance(chain, angles, directions)
    count = min(_MOST, angles.shape[1])
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :count]
    return (
        np.take_along_axis(angles, nearest[..., None], axis=1),
        np.take_along_axis(distance, nearest, axis=1),
    )


def _nearest_path(angles: Array, distance: Array) -> Array:
    """Return the path that goes on with the nearest candidate, shape (T, 4), rad."""
    path = np.empty((len(angles), 4))
    near = np.zeros(4)
    for t, (now, off) in enumerate(zip(angles, distance, strict=True)):
        step = np.sum((now - near) ** 2, axis=1)
        near = path[t] = now[np.argmin(step + _CLOSE * off)]
    return path


def _between(angles: Array, known: NDArray[np.intp], frames: int, cyclic: bool) -> Array:
    """Return a path between known steps, shape (T, 4), rad."""
    if cyclic:
        angles, known = np.concatenate([angles, angles[:1]]), np.append(known, frames)
    steps = np.arange(frames)
    return np.stack([np.interp(steps, known, joint) for joint in angles.T], axis=1)
