"""Hidden Markov model of a state that switches: which of W plants is on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["filtered", "predicted", "smoothed"]

Array = NDArray[np.float64]

_LEAST_LOG = -50.0  # log likelihoods below the largest by more than this are equal
_LARGEST = np.finfo(np.float64).max
_LEAST = 1e-30  # no state is excluded for ever


def predicted(belief: Array, enabled: NDArray[np.bool_], h: float) -> Array:
    """Compute the belief before a step's evidence, (1-h) b + h / W.

    Args:
        belief: Belief b of the step before, shape (..., W), 0 where a state is not enabled.
        enabled: Which states there are, shape (..., W); W counts them.
        h: Switching probability, a step.

    Returns:
        Belief, shape (..., W), that sums to 1; 0 where no state is enabled. One state stays.
    """
    if belief.shape[-1] == 1:
        return belief
    count = np.maximum(enabled.sum(axis=-1, keepdims=True), 1)
    return (1.0 - h) * belief + h * enabled / count


def filtered(prior: Array, log_likelihood: Array) -> Array:
    """Compute the belief after a step's evidence, b ∝ ℓ p.

    Args:
        prior: Belief p before, shape (..., W), 0 where a state is not enabled.
        log_likelihood: log ℓ of the evidence, shape (..., W).

    Returns:
        Belief, shape (..., W), that sums to 1.
    """
    joint = prior * _likelihood(log_likelihood, prior > 0.0)
    return joint / np.maximum(joint.sum(axis=-1, keepdims=True), _LEAST)


def smoothed(log_likelihood: Array, h: float) -> Array:
    """Compute the belief at each step, given the evidence of all steps.

    This is forward-backward (Rabiner 1989).

    Args:
        log_likelihood: log ℓ of the evidence, shape (T, W).
        h: Switching probability, a step.

    Returns:
        Posterior, shape (T, W), that sums to 1 over states.
    """
    steps, states = log_likelihood.shape
    if states == 1:
        return np.ones((steps, 1))
    likelihood = _likelihood(log_likelihood, np.ones(states, bool))
    posterior = np.empty_like(likelihood)
    belief = np.full(states, 1.0 / states)
    for t in range(steps):
        belief = ((1.0 - h) * belief + h / states) * likelihood[t]
        belief /= belief.sum()
        posterior[t] = belief
    later = np.ones(states)
    for t in range(steps - 1, -1, -1):
        posterior[t] *= later
        later = later * likelihood[t]
        later = (1.0 - h) * later + h / states * later.sum()
        later /= later.sum()
    return posterior / posterior.sum(axis=1, keepdims=True)


def _likelihood(log_likelihood: Array, enabled: NDArray[np.bool_]) -> Array:
    """Return likelihoods relative to the largest, 0 where a state is not enabled."""
    logs = np.where(enabled, log_likelihood, -_LARGEST)
    relative = np.exp(np.maximum(logs - logs.max(axis=-1, keepdims=True), _LEAST_LOG))
    return (relative + _LEAST) * enabled
