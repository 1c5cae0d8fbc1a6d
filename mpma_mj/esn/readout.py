"""Linear readouts of reservoirs: fitted by ridge regression, or moved step by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

__all__ = ["ReadoutBank"]

Array = NDArray[np.float64]

_EPSILON = 1e-6  # keeps features of 0 from dividing by 0


class ReadoutBank:
    """Readouts of a reservoir bank, output_i = W_out,i z_i, that remember earlier epochs.

    Weighted least squares with forgetting φ and ridge ρ: after every epoch of T steps

        G_i ← φ G_i + Σ_t w_t z zᵀ      B_i ← φ B_i + Σ_t w_t z yᵀ      n ← φ n + T
        W_out,i = ((G_i + ρ n I)⁻¹ B_i)ᵀ

    With φ = 0 it is plain ridge regression on the last epoch. `nudge` learns a step instead.

    Attributes:
        weights: W_out, shape (M, K, F).
    """

    def __init__(self, weights: Array, *, forgetting: float = 0.0, ridge: float = 1.0) -> None:
        """Start from given readouts and no memory.

        Args:
            weights: Initial W_out, shape (M, K, F): modules, outputs, features.
            forgetting: φ, in [0, 1].
            ridge: ρ, above 0.
        """
        count, outputs, features = weights.shape
        self.weights = weights.copy()
        self._forgetting = forgetting
        self._ridge = ridge
        self._gram = np.zeros((count, features, features))
        self._moment = np.zeros((count, features, outputs))
        self._steps = 0.0

    def __call__(self, features: Array) -> Array:
        """Read the reservoirs: features (M, F) to outputs (M, K)."""
        return (self.weights @ features[..., None])[..., 0]

    def fit(self, features: Array, targets: Array, step_weights: Array | None = None) -> None:
        """Learn an epoch.

        Args:
            features: Features z, shape (T, M, F).
            targets: What the readouts should have said, shape (T, M, K) or, the same for all
                modules, (T, 1, K).
            step_weights: Weight w of every step for every module, shape (T, M); 1 if not given.
        """
        steps, count, size = features.shape
        self._steps = self._forgetting * self._steps + steps
        ridge = self._ridge * self._steps * np.eye(size)
        targets = np.broadcast_to(targets, (steps, count, targets.shape[2]))
        for i in range(count):
            z = features[:, i]
            weighted = z if step_weights is None else z * step_weights[:, i, None]
            self._gram[i] = self._forgetting * self._gram[i] + weighted.T @ z
            self._moment[i] = self._forgetting * self._moment[i] + weighted.T @ targets[:, i]
            solution = linalg.solve(self._gram[i] + ridge, self._moment[i], assume_a="pos")
            self.weights[i] = solution.T

    def nudge(self, features: Array, errors: Array, rate: float) -> None:
        """Move the weights along an error by normalised LMS.

            W_out,i ← W_out,i + η e_i z_iᵀ / (ε + z_iᵀz_i)

        (Nagumo & Noda 1967.) Of the error on the same features 1 - η is left.

        Args:
            features: Features z, shape (M, F).
            errors: Errors e, what should have been said less what was, shape (M, K).
            rate: Learning rate η.
        """
        power = _EPSILON + np.sum(features**2, axis=1)  # (M,)
        step = rate * errors / power[:, None]
        self.weights += step[:, :, None] * features[:, None, :]

    def state_dict(self) -> dict[str, Array]:
        """Return a copy of everything that `fit` and reading depend on."""
        return {
            "weights": self.weights.copy(),
            "gram": self._gram.copy(),
            "moment": self._moment.copy(),
            "steps": np.array(self._steps),
        }

    def load_state_dict(self, state: dict[str, Array]) -> None:
        """Continue from a state that `state_dict` returned."""
        self.weights = state["weights"].copy()
        self._gram = state["gram"].copy()
        self._moment = state["moment"].copy()
        self._steps = float(state["steps"])
