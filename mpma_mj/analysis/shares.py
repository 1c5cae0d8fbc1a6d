"""Each module's share of what is danced: joints, labels, segments, regions of posture space.

All shares are over modules: each column sums to 1. A column is NaN where there is nothing to
share, such as a label that is not danced. They are to be read beside the module's mean
responsibility: one that is responsible half of the time has half of most things.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["group_share", "joint_share", "segment_movement", "segment_share"]

Array = NDArray[np.float64]


def joint_share(output: Array) -> Array:
    """Return each module's share of each joint's motor output.

        Σ_t |λ^i u^i_j| / Σ_k Σ_t |λ^k u^k_j|

    Args:
        output: Motor outputs λ^i u^i of the modules, shape (T, M, J).

    Returns:
        Shares, shape (M, J).
    """
    return _over_modules(np.abs(output).sum(axis=0))


def group_share(responsibility: Array, group: NDArray[np.int_], groups: int) -> Array:
    """Return each module's share of each group of steps, its mean λ in them.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        group: Which group a step belongs to, such as the label that is danced, shape (T,); -1
            for none.
        groups: Number of groups, G.

    Returns:
        Shares, shape (M, G).
    """
    members = (group[:, None] == np.arange(groups)).astype(np.float64)  # (T, G)
    return _over_modules(responsibility.T @ members)


def segment_share(responsibility: Array, movement: Array) -> Array:
    """Return each module's share of each segment's movement while it is responsible.

        Σ_t λ^i_t m_t / Σ_k Σ_t λ^k_t m_t

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        movement: How far each segment turns in each step, shape (T, S), rad.

    Returns:
        Shares, shape (M, S).
    """
    return _over_modules(responsibility.T @ movement)


def segment_movement(posture: Array) -> Array:
    """Return how far each segment turns in each step.

    Args:
        posture: Postures, shape (T + 1, 12), four unit vectors.

    Returns:
        Angles, shape (T, 4), rad, in the order of `kinematics.SEGMENT_NAMES`.
    """
    chord = np.linalg.norm(np.diff(posture.reshape(len(posture), -1, 3), axis=0), axis=-1)
    return 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))


def _over_modules(amount: Array) -> Array:
    """Divide each column by its sum; NaN where that is 0."""
    total = amount.sum(axis=0)
    return amount / np.where(total > 0.0, total, np.nan)
