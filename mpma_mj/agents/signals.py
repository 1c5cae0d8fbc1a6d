"""Signals of agents: what they computed at each step of an episode."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["MODULE_SIGNALS", "ModuleSignals"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModuleSignals:
    """Signals of M modules in the T steps of an episode; "…" is the shape of a batch of runs.

    Attributes:
        responsibility: Responsibilities λ, shape (T, …, M), that sum to 1.
        prior: Outputs p of the responsibility predictors, shape (T, …, M).
        module_actions: Actions u^i of the inverse models, shape (T, …, M, 8), in [-1, 1].
        predictions: Postures x̂^i that the forward models predict for the next step, shape
            (T, …, M, 12).
    """

    responsibility: Array
    prior: Array
    module_actions: Array
    predictions: Array

    def map(self, change: Any) -> ModuleSignals:
        """Return the signals with a function applied to each array."""
        return ModuleSignals(**{name: change(getattr(self, name)) for name in MODULE_SIGNALS})


MODULE_SIGNALS = tuple(field.name for field in fields(ModuleSignals))
"""Names of the signals of modules, also in files."""
