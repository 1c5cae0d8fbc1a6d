"""Schedule of the gains, by which control passes from feedback to inverse models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["CRITERION", "FINAL_FEEDBACK", "FINAL_GAINS", "Gains", "performance"]

Values = float | NDArray[np.float64]

# From the paper: K starts at 1 and has to fall below 0.15 (0.14 is a choice), L goes from 0.01
# to 1.
_FEEDBACK_START, _FEEDBACK_END = 1.0, 0.14
_INVERSE_START, _INVERSE_END = 0.01, 1.0

# Largest progress of one epoch (choice).
_RATE = 0.25

CRITERION = 3.0
"""The paper's criterion for predictions and for tracking, percent."""

FINAL_FEEDBACK = 0.15
"""The paper's bound: training ends with K below it."""


@dataclass(frozen=True)
class Gains:
    """Gains K and L of an epoch, linear in the progress s made so far.

        K = 1 - 0.86 s        L = 0.01 + 0.99 s

    Attributes:
        progress: Share s of the way from feedback to inverse models, in [0, 1]; of one run, or of
            each run of a batch, shape (R,).
    """

    progress: Values = 0.0

    @property
    def feedback(self) -> Values:
        """Gain K of the feedback controller."""
        return _FEEDBACK_START + (_FEEDBACK_END - _FEEDBACK_START) * self.progress

    @property
    def inverse(self) -> Values:
        """Gain L of the inverse models."""
        return _INVERSE_START + (_INVERSE_END - _INVERSE_START) * self.progress

    def after(self, performance: Values) -> Gains:
        """Return the next epoch's gains: s ← min(1, s + performance / 4)."""
        return Gains(np.minimum(1.0, self.progress + _RATE * performance))


FINAL_GAINS = Gains(1.0)
"""Gains when control has passed."""


def performance(prediction_error: float, untrained_error: float) -> float:
    """Return the performance that the gains follow.

    The paper does not define it. It must not be p_e: with K = 1 the feedback alone tracks well,
    and the schedule would end at once. It is the forward models' error, scaled to 0 in the first
    epoch and to 1 at the paper's 3 % (choice).

    Args:
        prediction_error: Prediction error of this epoch, percent.
        untrained_error: Prediction error of the first epoch, percent.

    Returns:
        Performance, in [0, 1].
    """
    way = max(untrained_error - CRITERION, 1e-9)
    return float(np.clip((untrained_error - prediction_error) / way, 0.0, 1.0))
