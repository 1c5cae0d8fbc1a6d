"""What a measure comes to by chance: the same signal at another time.

Movement, music and λ are all smooth and all repeat, so that any two of them look related, and
shuffling single steps would hide that. A signal that is shifted in time keeps its values, its
smoothness and its repetitions and loses only the alignment. The mean over such shifts contains
the bias of an estimator from few samples as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["BesideChance", "beside_chance"]

Array = NDArray[np.float64]

_SHIFTS = 32  # evenly spread over a repetition (choice)


@dataclass(frozen=True, eq=False)
class BesideChance:
    """A measure, and what it is by chance.

    Attributes:
        value: The measure.
        by_chance: Its mean over shifts of one signal against the others, of the same shape.
    """

    value: Array
    by_chance: Array


def beside_chance(
    measure: Callable[[NDArray[Any]], Array], signal: NDArray[Any], period: int
) -> BesideChance:
    """Measure a signal as it is and shifted in time.

    Args:
        measure: What is measured, a function of the signal.
        signal: Signal, shape (T, ...).
        period: Steps of one repetition, at least 2.
    """
    spread = np.linspace(0.0, period, _SHIFTS + 2)[1:-1].round().astype(int)
    shifts = np.unique(np.clip(spread, 1, period - 1))
    shifted = [measure(np.roll(signal, shift, axis=0)) for shift in shifts]
    return BesideChance(measure(signal), np.mean(shifted, axis=0))
