"""Mutual information of discrete signals, in bits.

Estimated from relative frequencies, which is too high by about (a-1)(b-1) / (2 T ln 2) for T
independent samples of a and b symbols (Miller 1955), and by more where samples depend on each
other: read it beside chance, see `chance`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.cluster import KMeans
from sklearn.metrics import mutual_info_score

__all__ = ["REGIONS", "entropy_bits", "information_bits", "posture_regions"]

Array = NDArray[np.float64]
Symbols = NDArray[Any]

REGIONS = 8
"""Number of regions into which posture space is divided (choice)."""


def entropy_bits(symbols: Symbols) -> float:
    """Return the entropy of symbols, shape (T,), in bits."""
    return information_bits(symbols, symbols)


def information_bits(symbols: Symbols, *signals: Symbols) -> float:
    """Return what signals together tell about symbols.

    Args:
        symbols: What is told about, shape (T,).
        *signals: What tells, each shape (T,).

    Returns:
        Mutual information, bits: 0 if they tell nothing, the entropy if they tell all.
    """
    _, joint = np.unique(np.stack(signals, axis=1), axis=0, return_inverse=True)
    return float(mutual_info_score(symbols, joint.ravel()) / np.log(2.0))


def posture_regions(posture: Array) -> NDArray[np.int_]:
    """Divide the postures that occur into regions, by k-means.

    Args:
        posture: Postures, shape (T, 12).

    Returns:
        Region of each posture, shape (T,), 0 to at most 7, numbered in the order in which they are
        first entered.
    """
    regions = min(REGIONS, len(np.unique(posture, axis=0)))
    found = KMeans(regions, n_init=10, random_state=0).fit_predict(posture)
    _, first, region = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[region]
