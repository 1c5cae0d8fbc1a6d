"""Who controls: likelihoods, responsibilities, and what responsibility predictors learn.

Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001 (MOSAIC), as taken up by the paper.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["likelihood", "prediction_errors", "predictor_target", "responsibilities"]

Array = NDArray[np.float64]

_LEAST_SHARE = 1e-6  # so that a module that was never used can come back (choice)
_BALANCING_ROUNDS = 10  # rounds (choice); after one alone, fewer runs use all modules


def prediction_errors(predictions: Array, posture: Array) -> Array:
    """Compute each module's error: mean over d of (x_d - x̂ⁱ_d)².

    Args:
        predictions: What the forward models expected, x̂, shape (..., M, 12).
        posture: What came, x, shape (..., 12).

    Returns:
        Mean squared errors, shape (..., M).
    """
    off = predictions - posture[..., None, :]
    return np.vecdot(off, off) / posture.shape[-1]


def likelihood(errors: Array, sigma: float | Array) -> Array:
    """Compute how likely each module's prediction makes what came.

        ℓⁱ = exp(-(errⁱ - min_j errʲ) / 2σ²)

    Subtracting the least error changes no responsibility and keeps the exponential from
    vanishing for all modules at once.

    Args:
        errors: Mean squared prediction errors, shape (..., M).
        sigma: Error at which a module begins to lose, in units of posture, shape (...).

    Returns:
        Likelihoods, shape (..., M), in [0, 1], the best module's 1.
    """
    width = 2.0 * np.asarray(sigma)[..., None] ** 2
    return np.exp((np.minimum.reduce(errors, axis=-1, keepdims=True) - errors) / width)


def responsibilities(prior: Array, likelihoods: Array) -> Array:
    """Compute the responsibilities, λⁱ = pⁱ ℓⁱ / Σ_j pʲ ℓʲ.

    Args:
        prior: Output p of the responsibility predictors, shape (..., M), above 0.
        likelihoods: Likelihoods, shape (..., M).

    Returns:
        Responsibilities, shape (..., M), that sum to 1.
    """
    joint = prior * likelihoods
    return joint / np.add.reduce(joint, axis=-1, keepdims=True)


def predictor_target(responsibility: Array, sharpening: float) -> Array:
    """Compute what responsibility predictors learn under the weighted rule (choice).

        y ∝ (λⁱ)^γ cⁱ        with cⁱ such that modules are used nearly alike, mean_t yⁱ ≈ 1 / M

    γ > 1 makes modules commit; cⁱ is a conscience (DeSieno 1988) that keeps one from winning
    everything. It is found by evening out modules and steps in turn (Sinkhorn & Knopp 1967), for
    a few rounds: more would change little in the end, as the next epoch goes on from there.

    Args:
        responsibility: Responsibilities of an epoch, shape (T, M).
        sharpening: γ.

    Returns:
        Targets, shape (T, M), that sum to 1 over modules.
    """
    target = np.maximum(responsibility, _LEAST_SHARE) ** sharpening
    for _ in range(_BALANCING_ROUNDS):
        target = target / target.mean(axis=0)
        target /= target.sum(axis=1, keepdims=True)
    return target
