"""Whether modules go by posture or by music."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.analysis.chance import BesideChance, beside_chance
from mpma_mj.analysis.information import entropy_bits, information_bits
from mpma_mj.analysis.readout import readout_r2

__all__ = ["Told", "what_tells"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Told:
    """How much posture and context tell about responsibility.

    The sources are "posture", "context", "posture beyond context" and "context beyond posture":
    what the one adds where the other is known already. Every array has shape (1 + M,): all modules
    together, then each by itself, which is about its λ, and about whether it is the dominant one.

    Attributes:
        entropy: Entropy of the dominant module, shape (1 + M,), bits.
        r2: What a linear readout explains of λ, see `readout_r2`; for each source.
        bits: Mutual information with the dominant module, bits; for each source. Of posture, the
            region tells; of the context, the label.
    """

    entropy: Array
    r2: dict[str, BesideChance]
    bits: dict[str, BesideChance]


def what_tells(
    responsibility: Array,
    posture: Array,
    context: Array,
    region: NDArray[np.int_],
    label: NDArray[np.int_],
    period: int,
) -> Told:
    """Compare what posture and context tell about responsibility.

    Args:
        responsibility: Responsibilities λ, shape (T, M).
        posture: Postures, shape (T, 12).
        context: Context, shape (T, C).
        region: Region of each posture, shape (T,).
        label: Label that is danced, shape (T,); -1, for none, is a label too (choice).
        period: Steps of one repetition.
    """
    dominant = responsibility.argmax(axis=1)
    questions = [dominant, *(dominant == i for i in range(responsibility.shape[1]))]

    def r2(*signals: Array) -> Array:
        return readout_r2(responsibility, np.concatenate(signals, axis=1), period)

    def bits(*signals: NDArray[Any]) -> Array:
        return np.array([information_bits(question, *signals) for question in questions])

    return Told(
        entropy=np.array([entropy_bits(question) for question in questions]),
        r2=_of_sources(r2, posture, context, period),
        bits=_of_sources(bits, region, label, period),
    )


def _of_sources(
    told_by: Callable[..., Array], posture: NDArray[Any], context: NDArray[Any], period: int
) -> dict[str, BesideChance]:
    """Return what each source tells; by chance, that source is at another time than the rest."""
    return {
        "posture": beside_chance(told_by, posture, period),
        "context": beside_chance(told_by, context, period),
        "posture beyond context": beside_chance(
            lambda x: told_by(x, context) - told_by(context), posture, period
        ),
        "context beyond posture": beside_chance(
            lambda y: told_by(posture, y) - told_by(posture), context, period
        ),
    }
