"""Linear readouts of λ: how much of it can be told from something else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LinearRegression
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict

__all__ = ["readout_r2"]

Array = NDArray[np.float64]

_CONSTANT = 1e-12  # a variance under it is rounding


def readout_r2(responsibility: Array, signal: Array, period: int) -> Array:
    """Return how much of λ a linear readout explains, cross-validated over repetitions.

        R² = 1 - Σ (λ - λ̂)² / Σ (λ - mean λ)²

    where λ̂ in each repetition is the least-squares readout that was fitted to the others.
    Repetitions are alike, so this holds out noise, not another movement.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        signal: What is read out, shape (T, D).
        period: Steps of one repetition; the last may be cut short.

    Returns:
        R², shape (1 + M,): of all modules together, that is sums over them too, then of each. At
        most 1; below 0 where the mean alone would do better; NaN where λ is constant, and
        everywhere where there is only one repetition.
    """
    steps, modules = responsibility.shape
    if steps <= period:
        return np.full(1 + modules, np.nan)
    readout = cross_val_predict(
        LinearRegression(),
        signal,
        responsibility,
        groups=np.arange(steps) // period,
        cv=LeaveOneGroupOut(),
    )
    missed = _with_total(np.sum((responsibility - readout.reshape(steps, modules)) ** 2, axis=0))
    varied = _with_total(np.sum((responsibility - responsibility.mean(axis=0)) ** 2, axis=0))
    return 1.0 - missed / np.where(varied > _CONSTANT * steps, varied, np.nan)


def _with_total(sums: Array) -> Array:
    return np.concatenate([[sums.sum()], sums])
