"""Reward of imitation: one bounded term for each segment of the arms."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SEGMENT_NAMES

__all__: list[str] = ["mean_reward", "reward_weights", "segment_rewards", "site_distance"]

Array = NDArray[np.float64]

# Distance between demonstrated and actual unit vector at which a reward term falls to 0.1;
# 0.5 is an angle of 29 degrees. (choice)
_MARGIN = 0.5
_DECAY = math.log(0.1) / _MARGIN**2


def segment_rewards(posture: Array, reference: Array) -> Array:
    """Return the reward terms of the four segments, 1 in the demonstrated direction.

        r = 0.1^(d²/m²)        d distance of the unit vectors, m the margin

    This is dm_control's Gaussian `tolerance`.

    Args:
        posture: Postures, shape (..., 12).
        reference: Demonstrated postures, shape (..., 12).

    Returns:
        Terms in the order of `SEGMENT_NAMES`, shape (..., 4), in [0, 1].
    """
    offset = (posture - reference).reshape((*posture.shape[:-1], 4, 3))
    # `vecdot` treats each vector alone, so that one of many postures has the terms of a single one.
    return np.exp(_DECAY * np.vecdot(offset, offset))


def reward_weights(weights: Mapping[str, float]) -> Array:
    """Return normalised weights of all terms, shape (4,).

    Args:
        weights: Weights by name of the segment; 1 where none is given.
    """
    full = np.array([weights.get(name, 1.0) for name in SEGMENT_NAMES])
    full /= full.sum()
    while mean_reward(np.ones(4), full) > 1.0:  # by rounding
        full = np.nextafter(full, 0.0)
    return full


def mean_reward(terms: Array, weights: Array) -> Array:
    """Return the weighted mean of terms, shape (..., 4), over the last axis."""
    return np.vecdot(terms, weights)


def site_distance(posture: Array, reference: Array, segment_lengths: Array) -> Array:
    """Return the greatest distance of an elbow or wrist from its demonstrated position.

    Args:
        posture: Postures, shape (..., 12).
        reference: Demonstrated postures, shape (..., 12).
        segment_lengths: Lengths of the four segments, shape (4,), m.

    Returns:
        Distance, shape (...), m.
    """
    offset = (posture - reference).reshape(*posture.shape[:-1], 2, 2, 3)
    offset = np.cumsum(offset * segment_lengths.reshape(2, 2, 1), axis=-2)  # elbow, then wrist
    return np.sqrt(np.vecdot(offset, offset)).max(axis=(-2, -1))
