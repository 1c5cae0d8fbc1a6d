"""Information about responsibility in posture and context, compared with chance.

Motion, context and λ are smooth and repeat, so that any two of them look related. Chance is what a
measure gives for the same signal shifted in time: that keeps its values, smoothness and
repetitions, and contains the bias of estimators from few samples as well. Shuffling single steps
would not.

Mutual information is estimated from relative frequencies, which is too high by about
(a-1)(b-1) / (2 T ln 2) bits for T independent samples of a and b symbols (Miller 1955), and by more
where samples depend on each other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.cluster import KMeans
from sklearn.linear_model import LinearRegression
from sklearn.metrics import mutual_info_score
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict

__all__ = [
    "REGIONS",
    "Estimate",
    "ResponsibilityInformation",
    "entropy_bits",
    "estimate",
    "information_bits",
    "posture_regions",
    "readout_r2",
    "responsibility_information",
]

Array = NDArray[np.float64]
Symbols = NDArray[Any]

REGIONS = 8
"""Number of regions into which posture space is divided (choice)."""

_SHIFTS = 32  # evenly spread over a repetition (choice)
_CONSTANT = 1e-12  # variance below which a signal is constant but for rounding


@dataclass(frozen=True, eq=False)
class Estimate:
    """A measure, and its value by chance.

    Attributes:
        value: The measure.
        by_chance: Its mean over shifts of one signal against the others, of the same shape.
    """

    value: Array
    by_chance: Array


@dataclass(frozen=True, eq=False)
class ResponsibilityInformation:
    """Information about responsibility in posture and context.

    The sources are "posture", "context", "posture beyond context" and "context beyond posture":
    what the one adds to the other. Every array has shape (1 + M,): all modules together, then each
    by itself, which is about its λ, and about whether it is the dominant one.

    Attributes:
        entropy_bits: Entropy of the dominant module, shape (1 + M,), bits.
        r2: R² of a linear readout of λ, see `readout_r2`, for each source.
        bits: Mutual information with the dominant module, bits, for each source: of the region of
            the posture, and of the label.
    """

    entropy_bits: Array
    r2: dict[str, Estimate]
    bits: dict[str, Estimate]


def responsibility_information(
    responsibility: Array,
    posture: Array,
    context: Array,
    region: NDArray[np.int_],
    label: NDArray[np.int_],
    period: int,
) -> ResponsibilityInformation:
    """Return the information about responsibility in posture and context.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        posture: Postures, shape (T, 12).
        context: Context, shape (T, C).
        region: Region of each posture, shape (T,).
        label: Index of the active label, shape (T,); -1, for none, counts as a label (choice).
        period: Steps of one repetition.
    """
    dominant = responsibility.argmax(axis=1)
    symbols = [dominant, *(dominant == i for i in range(responsibility.shape[1]))]

    def r2(*signals: Array) -> Array:
        return readout_r2(responsibility, np.concatenate(signals, axis=1), period)

    def bits(*signals: Symbols) -> Array:
        return np.array([information_bits(one, *signals) for one in symbols])

    return ResponsibilityInformation(
        entropy_bits=np.array([entropy_bits(one) for one in symbols]),
        r2=_of_sources(r2, posture, context, period),
        bits=_of_sources(bits, region, label, period),
    )


def _of_sources(
    measure: Callable[..., Array], posture: Symbols, context: Symbols, period: int
) -> dict[str, Estimate]:
    """Return the measure of each source; by chance, that source is shifted against the rest."""
    return {
        "posture": estimate(measure, posture, period),
        "context": estimate(measure, context, period),
        "posture beyond context": estimate(
            lambda x: measure(x, context) - measure(context), posture, period
        ),
        "context beyond posture": estimate(
            lambda y: measure(posture, y) - measure(posture), context, period
        ),
    }


def estimate(measure: Callable[[Symbols], Array], signal: Symbols, period: int) -> Estimate:
    """Measure a signal as it is and shifted in time.

    Args:
        measure: Function of the signal.
        signal: Signal, shape (T, ...).
        period: Steps of one repetition, at least 2.
    """
    spread = np.linspace(0.0, period, _SHIFTS + 2)[1:-1].round().astype(int)
    shifts = np.unique(np.clip(spread, 1, period - 1))
    shifted = [measure(np.roll(signal, shift, axis=0)) for shift in shifts]
    return Estimate(measure(signal), np.mean(shifted, axis=0))


def entropy_bits(symbols: Symbols) -> float:
    """Return the entropy of symbols, shape (T,), bits."""
    return information_bits(symbols, symbols)


def information_bits(symbols: Symbols, *signals: Symbols) -> float:
    """Return the mutual information of symbols and signals together, bits.

    Args:
        symbols: Symbols, shape (T,).
        *signals: Signals, each shape (T,).
    """
    _, joint = np.unique(np.stack(signals, axis=1), axis=0, return_inverse=True)
    return float(mutual_info_score(symbols, joint.ravel()) / np.log(2.0))


def posture_regions(posture: Array) -> NDArray[np.int_]:
    """Divide postures into regions, by k-means.

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


def readout_r2(responsibility: Array, signal: Array, period: int) -> Array:
    """Return R² of a linear readout of λ, cross-validated over repetitions.

        R² = 1 - Σ (λ - λ̂)² / Σ (λ - mean λ)²

    where λ̂ in each repetition is the least-squares readout that was fitted to the others.
    Repetitions are alike, so this holds out noise, not another motion.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        signal: Input of the readout, shape (T, D).
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
