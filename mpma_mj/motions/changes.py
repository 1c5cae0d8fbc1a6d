"""Parts of a movement that has no labels of its own, found where the movement changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError

__all__ = ["change_points"]

Array = NDArray[np.float64]

_MOST_POSTURES = 2000  # that are compared, as the time grows with their square (choice)
_VELOCITY_WEIGHT = 0.6  # against posture's 1; more of it takes holds for parts (choice)
_SHORTEST = 4  # times a part may be shorter than if all were equal (choice)


def change_points(posture: Array, segments: int) -> NDArray[np.int_]:
    """Cut a movement into parts where it changes.

    The parts are those within which postures and velocities are most alike, measured by a
    Gaussian kernel, over all ways to cut (Arlot, Celisse & Harchaoui 2019, JMLR 20(162)). That
    puts a change in the middle of the move that makes it. Like a label of the music, a part
    begins with the move instead: where the speed had its last minimum before.

    Args:
        posture: Postures in the order of time, shape (T, 12), four unit vectors.
        segments: Number of parts, C.

    Returns:
        Part of each posture, shape (T,), from 0 to C - 1, none of them left out.

    Raises:
        BadOptionError: `segments` is below 1, or more than the postures to tell them apart.
    """
    if segments < 1:
        raise BadOptionError(option="segments", value=segments, expected="at least 1")
    frames = len(posture)
    step = max(1, -(-frames // _MOST_POSTURES))
    starts = np.arange(0, frames, step)  # (N,)
    if segments > len(starts):
        raise BadOptionError(
            option="segments",
            value=segments,
            expected=f"at most {len(starts)}, as the movement has {frames} postures",
        )
    if segments == 1:
        return np.zeros(frames, np.int_)
    velocity = np.diff(posture, axis=0, prepend=posture[:1])  # per posture, not per second
    features = _features(_means(posture, starts), _means(velocity, starts))
    cuts = starts[_cuts(features, segments)]
    speed = np.linalg.norm(velocity, axis=1)
    return np.repeat(np.arange(segments), np.diff([*_back_to_rest(cuts, speed), frames]))


def _means(values: Array, starts: NDArray[np.int_]) -> Array:
    """Return the means of stretches, shape (N, 12), of values, shape (T, 12)."""
    lengths = np.diff([*starts, len(values)])
    return np.add.reduceat(values, starts, axis=0) / lengths[:, None]


def _features(posture: Array, velocity: Array) -> Array:
    """Return posture beside velocity, scaled to a comparable spread, shape (N, 24)."""
    spread, speed = (np.sqrt(np.var(x, axis=0).sum()) for x in (posture, velocity))
    weight = _VELOCITY_WEIGHT * spread / speed if speed > 0 else 0.0
    return np.concatenate([posture, weight * velocity], axis=1)


def _cuts(features: Array, segments: int) -> NDArray[np.int_]:
    """Return where each part begins, shape (C,), for features of shape (N, 24)."""
    from ruptures import KernelCPD  # takes a second

    shortest = max(1, len(features) // (_SHORTEST * segments))
    found = KernelCPD(kernel="rbf", min_size=shortest).fit_predict(features, n_bkps=segments - 1)
    return np.array([0, *found[:-1]])


def _back_to_rest(cuts: NDArray[np.int_], speed: Array) -> list[int]:
    """Move each cut, shape (C,), back to the minimum of speed, shape (T,), before it."""
    moved = [0]
    for cut in cuts[1:].tolist():
        while cut - 1 > moved[-1] and speed[cut - 1] < speed[cut]:
            cut -= 1
        moved.append(cut)
    return moved
