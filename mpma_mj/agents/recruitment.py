"""How many modules an agent that grows has, epoch after epoch."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

__all__ = ["EPOCHS", "LEAST_GAIN", "Recruitment"]

Array = NDArray[np.float64]

EPOCHS = 4
"""Epochs with each number of modules; the first is not judged, it is new to the last module
(choice)."""

LEAST_GAIN = 0.03
"""Part of the prediction error that one more module must take away to have helped (choice)."""


@dataclass(frozen=True)
class Recruitment:
    """Where growth is.

    Every number of modules is tried for `EPOCHS` epochs. A module has helped if the mean
    prediction error is then `LEAST_GAIN` lower than without it. The first that has not is taken
    away again, and growth is over; as it is when there are as many as there may be.

    Attributes:
        modules: Number of modules.
        epochs: Epochs danced with this number.
        error: Sum of the prediction errors of those that are judged, percent.
        best_error: Mean prediction error with one module less, percent.
        over: Whether growth is over.
    """

    modules: int = 1
    epochs: int = 0
    error: float = 0.0
    best_error: float = math.inf
    over: bool = False

    def after(self, error: float, most: int) -> Recruitment:
        """Return what it is after an epoch.

        Args:
            error: Prediction error of the epoch, percent.
            most: Most modules that there may be.
        """
        if self.over:
            return self
        judged = self.error + (error if self.epochs else 0.0)
        tried = replace(self, epochs=self.epochs + 1, error=judged)
        return tried if tried.epochs < EPOCHS else tried._next(most)

    def _next(self, most: int) -> Recruitment:
        mean = self.error / (EPOCHS - 1)
        if mean >= (1.0 - LEAST_GAIN) * self.best_error:
            return Recruitment(self.modules - 1, best_error=self.best_error, over=True)
        if self.modules == most:
            return Recruitment(self.modules, best_error=mean, over=True)
        return Recruitment(self.modules + 1, best_error=mean)

    def as_row(self) -> Array:
        """Return it as numbers, shape (5,)."""
        return np.array(astuple(self), np.float64)

    @classmethod
    def of_row(cls, row: Array) -> Recruitment:
        """Return what `as_row` made numbers of."""
        modules, epochs, error, best_error, over = row.tolist()
        return cls(int(modules), int(epochs), error, best_error, bool(over))
