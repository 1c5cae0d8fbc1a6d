"""Signals of an episode that agents record."""

from __future__ import annotations

from collections.abc import Callable
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
        prior: Priors p, shape (T, ..., M); NaN of modules of plants that only other runs of a
            batch recruited.
        module_actions: Actions u^i of the inverse models, shape (T, ..., M, 8).
        predictions: Predicted next postures x̂^i, shape (T, ..., M, 12).
    """

    responsibility: Array
    prior: Array
    module_actions: Array
    predictions: Array

    def map(self, change: Callable[[Array], Array]) -> ModuleSignals:
        """Return the signals after a change of each."""
        return ModuleSignals(**{name: change(getattr(self, name)) for name in MODULE_SIGNALS})

    def present(self) -> ModuleSignals:
        """Return the signals of one run without modules of plants that only others recruited.

        These come last. A module that is switched off, or never has control, stays.
        """
        count = int(np.isfinite(self.prior[:1]).sum())
        return self.map(lambda signal: np.ascontiguousarray(signal[:, :count]))


@dataclass(frozen=True, eq=False)
class AgentSignals:
    """Signals of the T steps of an episode.

    Attributes:
        feedback: The feedback controller's part of the action, K u_fb, shape (T, ..., 8); None
            where there is none.
        learned: What learning adds to the action, shape (T, ..., 8): L Σ_i λ^i (u^i - m) with the
            resolved-rate command m of joint models, m = 0 of others; None where nothing is learned.
        modules: Signals of modules; None of an agent without.
    """

    feedback: Array | None = None
    learned: Array | None = None
    modules: ModuleSignals | None = None


MODULE_SIGNALS = tuple(field.name for field in fields(ModuleSignals))
"""Names of the signals of modules."""
