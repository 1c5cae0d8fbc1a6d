"""Signals of an episode that agents record."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

__all__ = ["MODULE_SIGNALS", "AgentSignals", "ModuleSignals"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModuleSignals:
    """Signals of M modules in the T steps of an episode.

    Attributes:
        responsibility: Responsibilities λ, shape (T, ..., M), that sum to 1.
        prior: Priors p, shape (T, ..., M).
        module_actions: Actions u^i of the inverse models, shape (T, ..., M, 8).
        predictions: Predicted next postures x̂^i, shape (T, ..., M, 12).
    """

    responsibility: Array
    prior: Array
    module_actions: Array
    predictions: Array


@dataclass(frozen=True, eq=False)
class AgentSignals:
    """Signals of the T steps of an episode.

    Attributes:
        feedback: The feedback controller's part of the action, K u_fb, shape (T, ..., 8); None
            where there is none.
        modules: Signals of modules; None of an agent without.
    """

    feedback: Array | None = None
    modules: ModuleSignals | None = None


MODULE_SIGNALS = tuple(field.name for field in fields(ModuleSignals))
"""Names of the signals of modules."""
