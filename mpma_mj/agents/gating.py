"""Gating: responsibility by prior and likelihood, and targets of responsibility predictors.

Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001 (MOSAIC), as taken up by the paper.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Observation
from mpma_mj.agents.networks import Network, NetworkFactory, RunIndex
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.seeding import stream

if TYPE_CHECKING:
    from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts

__all__ = [
    "Gate",
    "ResponsibilityGate",
    "likelihood",
    "prediction_errors",
    "predictor_target",
    "responsibilities",
]

Array = NDArray[np.float64]

_LEAST_PRIOR = 0.01  # p_min: no module is excluded for ever (choice)

_LEAST_SHARE = 1e-6  # so that a module that was never used can return (choice)
_BALANCING_ROUNDS = 10  # with one alone, fewer runs use all modules (choice)


def prediction_errors(predictions: Array, posture: Array) -> Array:
    """Compute each module's error: mean over d of (x_d - x̂ⁱ_d)².

    Args:
        predictions: Predicted postures x̂, shape (..., M, 12).
        posture: Posture x that was reached, shape (..., 12).

    Returns:
        Mean squared errors, shape (..., M).
    """
    off = predictions - posture[..., None, :]
    return np.vecdot(off, off) / posture.shape[-1]


def likelihood(errors: Array, sigma: float | Array) -> Array:
    """Compute the likelihood of the reached posture under each module's prediction.

        ℓⁱ = exp(-(errⁱ - min_j errʲ) / 2σ²)

    Subtracting the least error changes no responsibility and keeps the exponential from
    vanishing for all modules at once.

    Args:
        errors: Mean squared prediction errors, shape (..., M).
        sigma: Width σ, in units of posture, shape (...).

    Returns:
        Likelihoods, shape (..., M), in [0, 1], the best module's 1.
    """
    width = 2.0 * np.asarray(sigma)[..., None] ** 2
    return np.exp((np.minimum.reduce(errors, axis=-1, keepdims=True) - errors) / width)


def responsibilities(prior: Array, likelihoods: Array) -> Array:
    """Compute the responsibilities, λⁱ = pⁱ ℓⁱ / Σ_j pʲ ℓʲ.

    Args:
        prior: Output p of the responsibility predictors, shape (..., M), above 0.
        likelihoods: Likelihoods, shape (..., M).

    Returns:
        Responsibilities, shape (..., M), that sum to 1.
    """
    joint = prior * likelihoods
    return joint / np.add.reduce(joint, axis=-1, keepdims=True)


def predictor_target(responsibility: Array, sharpening: float) -> Array:
    """Compute the responsibility predictors' targets under the weighted rule (choice).

        y ∝ (λⁱ)^γ cⁱ        with cⁱ such that modules are used nearly alike, mean_t yⁱ ≈ 1 / M

    γ > 1 sharpens the division; cⁱ balances usage (DeSieno 1988), so that no module wins
    everything. Modules and steps are normalised in turn (Sinkhorn & Knopp 1967) for a few rounds;
    more change little, as the next epoch continues from there.

    Args:
        responsibility: Responsibilities of an epoch, shape (T, M).
        sharpening: Exponent γ.

    Returns:
        Targets, shape (T, M), that sum to 1 over modules.
    """
    target = np.maximum(responsibility, _LEAST_SHARE) ** sharpening
    for _ in range(_BALANCING_ROUNDS):
        target = target / target.mean(axis=0)
        target /= target.sum(axis=1, keepdims=True)
    return target


class Gate(ABC):
    """A way to decide which modules control.

    Attributes:
        predictor: Responsibility predictors; None where there are none.
    """

    predictor: Network | None = None

    @abstractmethod
    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors p and responsibilities λ of a step, each of shape (..., M).

        Args:
            observation: Observation of the step.
            predictions: Postures x̂ that the forward models predicted for this step, shape
                (..., M, 12); None in the first step of an episode.
        """

    def reset(self, episode: int) -> None:  # noqa: B027, a hook
        """Begin an episode."""

    def observe_action(self, observation: Observation, action: Array) -> None:  # noqa: B027, a hook
        """Receive the action of a step."""

    @property
    def count(self) -> int:
        """Largest number of recruited plants in the batch."""
        return 1

    def assign(self, run: RunIndex, epoch: Epoch) -> Array:
        """Return the weight of each step of one run's epoch for each module, shape (T, M)."""
        return epoch.responsibility

    def adapt(  # noqa: B027, a hook
        self, run: RunIndex, epoch: Epoch, rule: LearningRule, readouts: Readouts
    ) -> None:
        """Adapt one run's gate after its readouts have learned from an epoch."""

    @abstractmethod
    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""

    @abstractmethod
    def drop_modules(self, modules: Sequence[int]) -> None:
        """Continue without some modules, (K,) of M, from the next reset."""

    @abstractmethod
    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""

    @abstractmethod
    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""


class ResponsibilityGate(Gate):
    """Responsibility by a prior from the context and a likelihood from prediction errors.

        p^i = clip(RP_i(y), p_min, 1)           λ^i = p^i ℓ^i / Σ_j p^j ℓ^j

    ℓ compares the forward models' last predictions with the posture that was reached; it is 1 for
    all modules in the first step. Ablations replace p or ℓ by 1 for all modules; the predictors
    learn all the same. (Wolpert & Kawato 1998; Haruno, Wolpert & Kawato 2001.)

    Attributes:
        sigma: Width σ of the likelihood, shape (...).
    """

    predictor: Network

    def __init__(
        self,
        networks: NetworkFactory,
        context_size: int,
        *,
        sigma: float,
        uses_prior: bool = True,
        uses_likelihood: bool = True,
    ) -> None:
        """Draw the responsibility predictors.

        Args:
            networks: What the agent's networks have in common.
            context_size: Size of the context, C.
            sigma: Width σ of the likelihood in the first epoch.
            uses_prior: Whether p is the predictors' output; otherwise 1.
            uses_likelihood: Whether ℓ depends on the prediction errors; otherwise 1.
        """
        self.predictor = networks.make("predictor", context_size, 1)
        self.sigma = np.full(np.shape(networks.seed), sigma)
        self._uses_prior, self._uses_likelihood = uses_prior, uses_likelihood
        # Random preferences for contexts, so that modules differ from the first step (choice).
        weights = self.predictor.readouts.weights  # (..., M, 1, F)
        for run in np.ndindex(self.sigma.shape):
            seed = int(np.asarray(networks.seed)[run])
            drawn = stream(seed, "preference").random((networks.modules, context_size))
            weights[(*run, ..., 0, slice(networks.config.nodes, None))] = drawn

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors p and responsibilities λ of a step, each of shape (..., M)."""
        prior = self._prior(self.predictor.step(observation["context"])[..., 0])
        if predictions is None:
            return prior, responsibilities(prior, np.ones_like(prior))
        errors = prediction_errors(predictions, observation["posture"])
        return prior, responsibilities(prior, self._likelihood(errors))

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's noise."""
        self.predictor.reset(episode)

    def adapt(self, run: RunIndex, epoch: Epoch, rule: LearningRule, readouts: Readouts) -> None:
        """Set one run's σ for the next epoch."""
        self.sigma[run] = rule.next_sigma(epoch, float(self.sigma[run]))

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self.sigma = self.sigma[runs]
        self.predictor.select_runs(runs)

    def drop_modules(self, modules: Sequence[int]) -> None:
        """Continue without some modules, (K,) of M, from the next reset."""
        self.predictor.drop_modules(modules)

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return self.predictor.state_dict() | {"sigma": self.sigma.copy()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self.predictor.load_state_dict(state)
        self.sigma[...] = state["sigma"]

    def _prior(self, outputs: Array) -> Array:
        """Return the priors p of the predictors' outputs, each of shape (..., M)."""
        return clip(outputs, _LEAST_PRIOR, 1.0) if self._uses_prior else np.ones_like(outputs)

    def _likelihood(self, errors: Array) -> Array:
        """Return the likelihoods ℓ of prediction errors, each of shape (..., M)."""
        return likelihood(errors, self.sigma) if self._uses_likelihood else np.ones_like(errors)
