"""Linear readouts of reservoirs, fitted by ridge regression or by normalised LMS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from mpma_mj.errors import BadOptionError
from mpma_mj.esn.reservoir import PRECISION, FeatureReplay, Features, Single, blocks
from mpma_mj.utils.saved_arrays import assign

__all__ = ["ReadoutBank", "Ridge"]

Array = NDArray[np.float64]

_LEAST_SINGLE = 1e-4  # ridge; with a smaller one, rounding of single-precision sums is visible
_EPSILON = 1e-6  # avoids a division by 0


class Ridge(NamedTuple):
    """Ridge that is added to G: (absolute · n) I + relative · diag G.

    Attributes:
        absolute: ρ, a step.
        relative: Share of each feature's own second moment, so that its unit does not matter.
    """

    absolute: float = 1.0
    relative: float = 0.0


_DEFAULT = Ridge()


class _Sums(NamedTuple):
    """Sums over the epochs that readouts were fitted to."""

    gram: Features  # G, (..., M, F, F)
    moment: Features  # B, (..., M, F, K)


class ReadoutBank:
    """Readouts of a reservoir bank, output_i = W_out,i z_i, with memory of earlier epochs.

    Weighted least squares with forgetting φ and ridge ρ. After every epoch of T steps:

        G_i ← φ G_i + Σ_t w_t z zᵀ      B_i ← φ B_i + Σ_t w_t z yᵀ      n_i ← φ n_i + Σ_t w_t
        W_out,i = ((G_i + ρ n_i I + ρ' diag G_i)⁻¹ B_i)ᵀ

    With φ = 0 it is plain ridge regression on the last epoch. Readouts with Σ_t w_t < 1 stay as
    they are. `partial_fit` learns from a step instead. G and B, by far the largest arrays, exist
    only where readouts are fitted.

    Arrays may begin with an axis of runs; `of_run` returns one run's readouts.

    Attributes:
        weights: W_out, shape (..., M, K, F).
    """

    def __init__(self, weights: Array, *, forgetting: float = 0.0, ridge: Ridge = _DEFAULT) -> None:
        """Begin with given weights and no memory.

        Args:
            weights: Initial W_out, shape (..., M, K, F): modules, outputs, features.
            forgetting: φ, in [0, 1].
            ridge: Ridge.
        """
        self.weights: Single = weights.astype(PRECISION)
        self._forgetting = forgetting
        self._ridge = ridge
        self._sums: _Sums | None = None
        self._steps = np.zeros(weights.shape[:-2])

    def __call__(self, features: Features) -> Array:
        """Return the outputs, shape (..., M', K), for features (..., M', F) of the first M'."""
        weights = self.weights[..., : features.shape[-2], :, :]
        return (weights @ features[..., None])[..., 0].astype(np.float64)

    def outputs(self, features: Features | FeatureReplay) -> Array:
        """Return one run's outputs in an episode, shape (T, M', K), for features (T, M', F)."""
        return np.concatenate([self(block) for _, block in blocks(features)])

    def of_run(self, index: tuple[int, ...]) -> ReadoutBank:
        """Return one run's readouts, (M, K, F), which share memory with these."""
        run: tuple[Any, ...] = (*index, ...)  # not a copy, also of a single number
        return self._part(run, run)

    def _part(self, view: tuple[Any, ...], steps: tuple[Any, ...]) -> ReadoutBank:
        part = ReadoutBank.__new__(ReadoutBank)
        part._forgetting, part._ridge = self._forgetting, self._ridge
        part.weights, part._steps = self.weights[view], self._steps[steps]
        # Allocated here, so that what is fitted in the part is seen in the whole.
        part._sums = _Sums(*(sums[view] for sums in self._accumulated()))
        return part

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R."""
        self.weights, self._steps = self.weights[runs], self._steps[runs]
        if self._sums is not None:
            self._sums = _Sums(*(sums[runs] for sums in self._sums))

    def fit(
        self, features: Features | FeatureReplay, targets: Array, step_weights: Array | None = None
    ) -> None:
        """Fit one run's readouts to an epoch and, by G and B, to those before.

        Args:
            features: Features z, shape (T, M, F).
            targets: Targets y, shape (T, M, K) or, the same for all modules, (T, 1, K).
            step_weights: Weight w of every step for every module, shape (T, M); 1 if not given.

        Raises:
            BadOptionError: The ridge is too small for the sums to be inverted.
        """
        steps, count, _ = features.shape
        gram, moment = self._accumulated()
        outputs = np.broadcast_to(targets.astype(PRECISION), (steps, count, targets.shape[2]))
        roots, total = None, np.full(count, float(steps))
        if step_weights is not None:
            total = step_weights[:, :count].sum(axis=0)
            roots = np.sqrt(step_weights, dtype=PRECISION)
        fitted = np.flatnonzero(total >= 1.0)
        self._steps[fitted] = self._forgetting * self._steps[fitted] + total[fitted]
        if self._forgetting < 1.0:
            gram[fitted] *= self._forgetting
            moment[fitted] *= self._forgetting
        for rows, block in blocks(features):
            for i in fitted:
                z, y = block[:, i], outputs[rows, i]
                if roots is not None:
                    z, y = roots[rows, i, None] * z, roots[rows, i, None] * y
                z = z.astype(gram.dtype, copy=False)
                gram[i] += z.T @ z
                moment[i] += z.T @ y
        for i in fitted:
            regular = gram[i].copy()
            diagonal = regular.ravel()[:: len(regular) + 1]  # a view
            diagonal += self._ridge.relative * diagonal + self._ridge.absolute * float(
                self._steps[i]
            )
            try:
                factor = linalg.cho_factor(regular, overwrite_a=True, check_finite=False)
            except linalg.LinAlgError:
                raise BadOptionError(
                    option="ridge",
                    value=self._ridge.absolute,
                    expected="a ridge large enough to fit readouts, such as 1e-4",
                ) from None
            self.weights[i] = linalg.cho_solve(factor, moment[i], check_finite=False).T

    def partial_fit(self, features: Features, errors: Array, rate: float) -> None:
        """Reduce an error by a step of normalised LMS (Nagumo & Noda 1967).

            W_out,i ← W_out,i + η e_i z_iᵀ / (ε + z_iᵀz_i)

        The error on the same features is then 1 - η times as large.

        Args:
            features: Features z, shape (..., M, F).
            errors: Errors e, target minus output, shape (..., M, K).
            rate: Learning rate η.
        """
        power = _EPSILON + np.sum(features**2, axis=-1, keepdims=True)  # (..., M, 1)
        step = (rate * errors / power).astype(PRECISION)
        self.weights += step[..., :, None] * features[..., None, :]

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state: dict[str, NDArray[Any]] = {"weights": self.weights, "steps": self._steps}
        if self._forgetting > 0.0:  # else the next epoch does not need them
            state |= self._accumulated()._asdict()
        return {name: value.copy() for name, value in state.items()}

    def load_state_dict(self, state: Mapping[str, Array], prefix: str = "") -> None:
        """Continue from the arrays that `state_dict` returned.

        Args:
            state: Arrays by name; others are left out.
            prefix: Beginning of the names.

        Raises:
            KeyError: An array is missing.
            ValueError: An array has another shape or type, or is not finite.
        """
        assign(self.weights, state[f"{prefix}weights"])
        assign(self._steps, state[f"{prefix}steps"])
        if self._forgetting > 0.0:
            for name, sums in self._accumulated()._asdict().items():
                assign(sums, state[f"{prefix}{name}"])

    def _accumulated(self) -> _Sums:
        """Return the sums, 0 before the first epoch."""
        if self._sums is None:
            *modules, outputs, features = self.weights.shape
            shapes = (*modules, features, features), (*modules, features, outputs)
            kind = PRECISION if max(self._ridge) >= _LEAST_SINGLE else np.float64
            self._sums = _Sums(*(np.zeros(shape, kind) for shape in shapes))
        return self._sums
