"""Synergies of the modules' motor outputs.

A synergy is a pattern of joints that are driven together, with a strength that varies in time
(Tresch, Cheung & d'Avella 2006; d'Avella & Bizzi 2005). Patterns and strengths are not
negative, so that each joint counts as two, one a direction, as muscles do. They are found by
non-negative matrix factorisation (Lee & Seung 1999).

Here the outputs of all modules are factorised together: a synergy that only one module uses
is that module's own, one that all use belongs to the motion rather than to a module.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sklearn.decomposition import NMF
from sklearn.exceptions import ConvergenceWarning

__all__ = ["ENOUGH", "Synergies", "factorise", "find_synergies", "halves", "variance_accounted_for"]

Array = NDArray[np.float64]

ENOUGH = 0.9
"""Variance accounted for that is enough, as is usual for synergies."""

# The variance accounted for is that of the factors found, so stopping early is no error.
_MOST_ITERATIONS = 500


@dataclass(frozen=True, eq=False)
class Synergies:
    """The least number K of synergies that is enough.

    Attributes:
        variance_accounted_for: For 1, 2, … factors, shape (2 J,) or as many as there are samples.
        patterns: Joints driven in the positive and the negative direction, shape (K, 2 J), each of
            length 1, the strongest synergy first.
        loads: Share of each synergy's strength that is in each module, shape (K, M).
        weights: Share of each synergy in the strength of all, shape (K,).
    """

    variance_accounted_for: Array
    patterns: Array
    loads: Array
    weights: Array


def find_synergies(
    output: Array, progress: Callable[[range], Iterable[int]] = lambda numbers: numbers
) -> Synergies:
    """Find the synergies of the modules' motor outputs.

    Args:
        output: Motor outputs λ^i u^i of the modules, shape (T, M, J), not all 0.
        progress: Wraps the numbers of factors that are tried, to show the progress.
    """
    steps, modules, _ = output.shape
    samples = halves(output).reshape(steps * modules, -1)
    tried = [factorise(samples, k) for k in progress(range(1, min(samples.shape) + 1))]
    explained = np.array([variance_accounted_for(samples, *found) for found in tried])
    strengths, patterns = tried[int(np.argmax(explained >= ENOUGH))]
    of_modules = strengths.reshape(steps, modules, -1).sum(axis=0).T  # (K, M)
    strongest = np.argsort(-of_modules.sum(axis=1), kind="stable")
    of_modules = of_modules[strongest]
    total = of_modules.sum(axis=1, keepdims=True)
    return Synergies(explained, patterns[strongest], of_modules / total, total[:, 0] / total.sum())


def halves(output: Array) -> Array:
    """Split outputs, shape (..., J), into positive and negative parts, shape (..., 2 J)."""
    return np.concatenate([np.maximum(output, 0.0), np.maximum(-output, 0.0)], axis=-1)


def factorise(samples: Array, factors: int) -> tuple[Array, Array]:
    """Factorise non-negative samples; deterministic.

    Args:
        samples: Samples, shape (N, D), at least 0 and not all 0.
        factors: Number of factors K, at most N and D.

    Returns:
        Strengths, shape (N, K), and patterns, shape (K, D), each of length 1.
    """
    model = NMF(factors, init="nndsvda", random_state=0, max_iter=_MOST_ITERATIONS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        strengths = model.fit_transform(samples)
    length = np.linalg.norm(model.components_, axis=1)
    return strengths * length, model.components_ / np.where(length > 0.0, length, 1.0)[:, None]


def variance_accounted_for(samples: Array, strengths: Array, patterns: Array) -> float:
    """Return 1 - Σ (v - s p)² / Σ v², the mean not subtracted (Tresch, Cheung & d'Avella 2006).

    Args:
        samples: Samples v, shape (N, D).
        strengths: Strengths s, shape (N, K).
        patterns: Patterns p, shape (K, D).
    """
    return float(1.0 - np.sum((samples - strengths @ patterns) ** 2) / np.sum(samples**2))
