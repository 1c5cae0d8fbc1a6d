"""How control passes from the feedback controller to the inverse models."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Gains"]

# From the paper: K from 1 until K < 0.15, L from 0.01 to 1.
_FEEDBACK_START, _FEEDBACK_END = 1.0, 0.14
_INVERSE_START, _INVERSE_END = 0.01, 1.0


@dataclass(frozen=True)
class Gains:
    """Gains of one epoch.

        K = 1 - 0.86 s        L = 0.01 + 0.99 s

    Attributes:
        progress: Share s of the way from feedback to inverse models, in [0, 1].
    """

    progress: float = 0.0

    @property
    def feedback(self) -> float:
        """Gain K of the feedback controller."""
        return _FEEDBACK_START + (_FEEDBACK_END - _FEEDBACK_START) * self.progress

    @property
    def inverse(self) -> float:
        """Gain L of the inverse models."""
        return _INVERSE_START + (_INVERSE_END - _INVERSE_START) * self.progress

    @property
    def final(self) -> bool:
        """Whether control has passed: L = 1 and K < 0.15, the paper's end of training."""
        return self.progress >= 1.0

    def after(self, performance: float, rate: float) -> Gains:
        return Gains(min(1.0, self.progress + rate * performance))
