"""Activation patterns that come back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["laid_over", "recurrence"]

Array = NDArray[np.float64]


def laid_over(signal: Array, period: int) -> Array:
    """Cut a signal into its repetitions.

    Args:
        signal: Signal, shape (T, ...).
        period: Steps of one repetition, P.

    Returns:
        Repetitions, shape (R, P, ...); NaN where the last is cut short.
    """
    repetitions = -(-len(signal) // period)
    cut = np.full((repetitions * period, *signal.shape[1:]), np.nan)
    cut[: len(signal)] = signal
    return cut.reshape(repetitions, period, *signal.shape[1:])


def recurrence(responsibility: Array, lags: int) -> Array:
    """Return how alike responsibility is to itself some steps later.

    The mean over t of the cosine between λ_t and λ_{t+lag}: 1 where the same modules share in the
    same way, 0 where others do. A peak at the period is a repetition; one before it, a pattern
    that comes back within a repetition, and how high all lie is told by the mean.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        lags: Number of lags, at most T.

    Returns:
        Likeness, shape (lags,), for lags 0, 1, 2, …; the first is 1.
    """
    direction = responsibility / np.linalg.norm(responsibility, axis=1, keepdims=True)
    steps = len(direction)
    return np.array(
        [np.mean(np.sum(direction[: steps - n] * direction[n:], axis=1)) for n in range(lags)]
    )
