"""How many modules an agent that grows has, epoch after epoch."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

__all__ = ["EPOCHS", "LEAST_GAIN", "PATIENCE", "Growth"]

Array = NDArray[np.float64]

EPOCHS = 4
"""Epochs with each number of modules; the first is not judged, it is new to the last module
(choice)."""

LEAST_GAIN = 0.05
"""Part of the prediction error that more modules must take away to have helped (choice)."""

PATIENCE = 2
"""Modules that may be added in vain, one after the other, before growth is over (choice)."""


@dataclass(frozen=True)
class Growth:
    """Where growth is.

    Every number of modules is tried for `EPOCHS` epochs. It has helped if the mean prediction
    error is `LEAST_GAIN` lower than with the last number that has. After `PATIENCE` modules in
    vain, or with as many as there may be, the agent goes back to that number and growth is over.

    Attributes:
        modules: Number of modules.
        epochs: Epochs danced with this number.
        error: Sum of the prediction errors of those that are judged, percent.
        best: Last number that has helped; 0 before the first is judged.
        best_error: Mean prediction error with it, percent.
        over: Whether growth is over.
    """

    modules: int = 1
    epochs: int = 0
    error: float = 0.0
    best: int = 0
    best_error: float = math.inf
    over: bool = False

    def after(self, error: float, most: int) -> Growth:
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

    def _next(self, most: int) -> Growth:
        mean = self.error / (EPOCHS - 1)
        helped = mean < (1.0 - LEAST_GAIN) * self.best_error
        best, best_error = (self.modules, mean) if helped else (self.best, self.best_error)
        over = self.modules == most or self.modules - best >= PATIENCE
        modules = best if over else self.modules + 1
        return Growth(modules, best=best, best_error=best_error, over=over)

    def as_row(self) -> Array:
        """Return it as numbers, shape (6,)."""
        return np.array(astuple(self), np.float64)

    @classmethod
    def of_row(cls, row: Array) -> Growth:
        """Return what `as_row` made numbers of."""
        modules, epochs, error, best, best_error, over = row.tolist()
        return cls(int(modules), int(epochs), error, int(best), best_error, bool(over))
