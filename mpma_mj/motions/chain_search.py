"""Search for joint angles of a chain over a whole motion: starts of a fit.

Candidates for each step are the exact branches, the nearest postures of branches beyond the joints'
ranges, and postures with the first or the third joint on a grid, as these may be nearly free; each
with the whole turns that lie within the ranges. Paths through them: the nearest from step to step,
and the cheapest of dynamic programs, one with fewer steps, in which the grids are fine enough.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import wrap
from mpma_mj.motions.cheapest_path import PathCost, cheapest_cycle, cheapest_path
from mpma_mj.robots.branches import branches, nearest_turns
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.held_joint import with_first, with_third
from mpma_mj.robots.nearest_posture import nearest_posture

__all__ = ["interpolated", "starting_paths"]

Array = NDArray[np.float64]

# Choices.
_FIRST, _THIRD = 32, 16  # angles of the grids
_MOST = 256  # candidates of a step
_STEPS = 20  # of the search for a nearest posture
_APART = 0.1  # s between the steps of the coarser search
_CLOSE = 100.0  # weight of squared distance beside squared steps, rad², on the nearest path

_FINE = PathCost()
# Moves from branch to branch, too.
_COARSE = PathCost(speed_weight=0.002, excess_from=1.0, farthest=1.5)


def starting_paths(
    directions: Array, chain: Chain, step: Array, rate: float, cyclic: bool
) -> list[Array]:
    """Return paths of joint angles from which a fit may start.

    Args:
        directions: Directions u and f, shape (T, 6).
        chain: The arm.
        step: Largest change of an angle from one step to the next, shape (4,), rad.
        rate: Steps per second, Hz.
        cyclic: Whether the end leads into the start.

    Returns:
        Joint angles, each shape (T, 4), rad, within the ranges.
    """
    exact = _within(chain, _exact(chain, directions))
    grids = _within(chain, _grids(chain, directions))
    near = _nearest(np.concatenate([exact, grids], axis=1), directions, chain)
    every = max(1, round(_APART * rate))
    some = slice(None, None, every)
    coarse = _cheapest(near[some], directions[some], chain, every * step, cyclic, _COARSE)
    return [
        _nearest_path(exact, directions, chain),
        _cheapest(exact, directions, chain, step, cyclic, _FINE),
        _cheapest(near, directions, chain, step, cyclic, _FINE),  # G1's ranges need it on YMCA
        interpolated(coarse, every, len(directions), chain, cyclic),
    ]


def interpolated(path: Array, every: int, frames: int, chain: Chain, cyclic: bool) -> Array:
    """Return a path, shape (frames, 4), rad, that is known every so many steps."""
    if cyclic:
        onward = path[-1:] + wrap(path[:1] - path[-1:])
        path = np.concatenate([path, np.where(chain.endless, onward, path[:1])])
    known = np.append(np.arange(0, frames, every), frames)[: len(path)]
    return np.stack([np.interp(np.arange(frames), known, joint) for joint in path.T], axis=1)


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
        low, high = chain.lowest[joint], chain.highest[joint]
        if chain.endless[joint]:
            low, high = -np.pi, np.pi
        high = min(high, low + 2.0 * np.pi)
        grid = np.broadcast_to(np.linspace(low, high, count), (len(directions), count))
        goal = np.broadcast_to(directions[:, None], (*grid.shape, 6))
        found.append(held(chain, goal, grid).reshape(len(directions), -1, 4))
    return np.concatenate(found, axis=1)


def _within(chain: Chain, angles: Array) -> Array:
    """Return angles, (T, N, 4), with all turns that lie within the ranges, clipped to these."""
    near = nearest_turns(chain, angles)
    wide = np.flatnonzero((chain.highest - chain.lowest > 2.0 * np.pi) & ~chain.endless)
    found = []
    for turned in itertools.product((0.0, 1.0), repeat=len(wide)):
        other = near.copy()
        other[..., wide] -= np.copysign(2.0 * np.pi, other[..., wide]) * turned
        found.append(np.clip(other, chain.lowest, chain.highest))
    return np.concatenate(found, axis=1)


def _distance(angles: Array, directions: Array, chain: Chain) -> Array:
    """Return the squared distance of candidates, (T, N, 4), to directions, shape (T, N)."""
    return np.sum((chain.directions(angles) - directions[:, None]) ** 2, axis=-1)


def _nearest(angles: Array, directions: Array, chain: Chain) -> Array:
    """Return the candidates that are nearest to the directions, shape (T, at most 256, 4)."""
    distance = _distance(angles, directions, chain)
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :_MOST]
    return np.take_along_axis(angles, nearest[..., None], axis=1)


def _cheapest(
    angles: Array, directions: Array, chain: Chain, step: Array, cyclic: bool, cost: PathCost
) -> Array:
    """Return the cheapest path through candidates, shape (T, N, 4): (T, 4), rad."""
    cheapest = cheapest_cycle if cyclic else cheapest_path
    return cheapest(angles, _distance(angles, directions, chain), step, cost, chain.endless)


def _nearest_path(angles: Array, directions: Array, chain: Chain) -> Array:
    """Return the path that goes on with the nearest candidate, shape (T, 4), rad."""
    path, near = np.empty((len(angles), 4)), np.zeros(4)
    distance = _distance(angles, directions, chain)
    for t, (now, off) in enumerate(zip(angles, distance, strict=True)):
        way = now - near
        way[:, chain.endless] = wrap(way[:, chain.endless])
        best = np.argmin(np.sum(way**2, axis=1) + _CLOSE * off)
        near = path[t] = now[best]
    path[:, chain.endless] = np.unwrap(path[:, chain.endless], axis=0)
    return path
