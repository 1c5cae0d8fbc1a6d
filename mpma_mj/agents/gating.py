"""Gating: responsibility by prior and likelihood, and targets of responsibility predictors.

Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001 (MOSAIC), as taken up by the paper.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpma_mj.agents.base import Observation
from mpma_mj.agents.networks import Network, NetworkFactory, RunIndex
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.seeding import stream
from mpma_mj.utils.validation import is_boolean

if TYPE_CHECKING:
    from mpma_mj.agents.learning_rules import Epoch, Readouts

__all__ = [
    "LEAST_SHARE",
    "Gate",
    "ResponsibilityGate",
    "balanced_preferences",
    "checked_mask",
    "learned_part",
    "likelihood",
    "mixed_outputs",
    "prediction_errors",
    "responsibilities",
]

Array = NDArray[np.float64]

_LARGEST = np.finfo(np.float64).max  # for the case that all errors are infinite
_TINY = np.finfo(np.float64).tiny
_LEAST_PRIOR = 0.01  # p_min: no module is excluded for ever (choice)
LEAST_SHARE = 1e-6
"""Least share of a label, so that a module that was never used can return (choice)."""
_BALANCING_ROUNDS = 10  # (choice)


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


def likelihood(errors: Array, sigma: float) -> Array:
    """Compute the likelihood of the reached posture under each module's prediction.

        ℓⁱ = exp(-(errⁱ - min_j errʲ) / 2σ²)

    Subtracting the least error changes no responsibility and keeps the exponential from
    vanishing for all modules at once.

    Args:
        errors: Mean squared prediction errors, shape (..., M).
        sigma: Width σ, in units of posture.

    Returns:
        Likelihoods, shape (..., M), in [0, 1], the best module's 1.
    """
    least = np.minimum(np.minimum.reduce(errors, axis=-1, keepdims=True), _LARGEST)
    return np.exp((least - errors) / (2.0 * sigma**2))


def responsibilities(prior: Array, likelihoods: Array) -> Array:
    """Compute the responsibilities, λⁱ = pⁱ ℓⁱ / Σ_j pʲ ℓʲ.

    Args:
        prior: Output p of the responsibility predictors, shape (..., M), above 0.
        likelihoods: Likelihoods, shape (..., M).

    Returns:
        Responsibilities, shape (..., M), that sum to 1; 0 where every prior is 0.
    """
    joint = prior * likelihoods
    return joint / np.maximum(np.add.reduce(joint, axis=-1, keepdims=True), _TINY)


def mixed_outputs(responsibility: Array, outputs: Array, modules: int) -> Array:
    """Compute the modules' common output, Σ_i λ^i (...)^i.

    It is summed plant by plant: plants that only other runs of a batch recruited change no bit.

    Args:
        responsibility: Responsibilities λ, shape (..., W · M).
        outputs: Outputs of the modules, shape (..., W · M, D).
        modules: Number of modules of a plant, M.

    Returns:
        Output, shape (..., D).
    """
    if responsibility.shape[-1] == modules:
        one: Array = responsibility[..., None, :] @ outputs
        return one[..., 0, :]
    plants = (*responsibility.shape[:-1], -1)
    shares = responsibility.reshape(*plants, 1, modules)
    mixed: Array = shares @ outputs.reshape(*plants, modules, outputs.shape[-1])
    return mixed[..., 0, :].sum(axis=-2)


def learned_part(
    responsibility: Array, module_actions: Array, command: Array | None, modules: int
) -> Array:
    """Return what the modules add to a command, Σ_i λ^i (u^i - m), shape (..., 8).

    Args:
        responsibility: Responsibilities λ, shape (..., W · M).
        module_actions: Actions u^i of inverse models, shape (..., W · M, 8).
        command: Command m that their outputs were added to, shape (..., 8); None if there was none.
        modules: Number of modules of a plant, M.
    """
    action = mixed_outputs(responsibility, module_actions, modules)
    if command is None:
        return action
    total = mixed_outputs(responsibility, np.ones((*responsibility.shape, 1)), modules)
    return action - total * command


def checked_mask(enabled: ArrayLike, modules: int) -> NDArray[np.bool_]:
    """Return which of a number of modules are enabled, shape (M,).

    Raises:
        BadOptionError: There are not as many modules, or an entry is no truth value.
    """
    mask = np.asarray(enabled, object)  # of any shape
    if mask.shape != (modules,) or not all(map(is_boolean, mask)):
        expected = f"{modules} truth values, one for each module"
        raise BadOptionError(option="enabled", value=mask.tolist(), expected=expected)
    return mask.astype(bool)


def balanced_preferences(shares: Array, visits: Array, sharpening: float) -> Array:
    """Compute preferences for labels from the shares that modules had of them (choice).

        p(c, k) ∝ L(c, k)^γ a_k        with a_k such that Σ_c v_c p(c, k) is alike for all k

    γ > 1 sharpens the division; a_k balances usage (DeSieno 1988). Labels and modules are
    normalised in turn (Sinkhorn & Knopp 1967) for a few rounds.

    Args:
        shares: Mean responsibility L of each module for each label, shape (C, M).
        visits: How often each label occurred, v, shape (C,), with a sum above 0.
        sharpening: Exponent γ.

    Returns:
        Preferences, shape (C, M), that sum to 1 over modules.
    """
    preferences = np.maximum(shares, LEAST_SHARE) ** sharpening
    for _ in range(_BALANCING_ROUNDS):
        preferences = preferences / (visits / visits.sum() @ preferences)
        preferences /= preferences.sum(axis=1, keepdims=True)
    return preferences


class Gate(ABC):
    """A way to decide which modules control.

    Attributes:
        compares_postures: Whether it compares predicted postures, whatever the models' space;
            otherwise the forward models' outputs.
        predictor: Responsibility predictors that learn by the rule; None where there are none.
        plants: Largest number of plants that were recruited in the batch.
        enabled: Which modules may control, shape (M,).
    """

    compares_postures: ClassVar[bool] = True
    predictor: Network | None = None
    plants: int = 1
    enabled: NDArray[np.bool_]

    def enable(self, mask: NDArray[np.bool_]) -> None:
        """Switch modules off or on, from the next step, by a mask of shape (W · M,)."""
        self.enabled[: len(mask)] = mask

    @abstractmethod
    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors p and responsibilities λ of a step, each of shape (..., M).

        Args:
            observation: Observation of the step.
            predictions: Postures x̂ that the forward models predicted for this step, shape
                (..., M, 12), or their outputs; None in the first step of an episode.
        """

    def reset(self, episode: int) -> None:  # noqa: B027, a hook
        """Begin an episode."""

    def observe_action(self, joint_angles: Array, state: Array, action: Array) -> None:  # noqa: B027, a hook
        """Receive joint angles, (..., 8), rad, proprioceptive state, (..., S), and action."""

    def assign(self, run: RunIndex, epoch: Epoch) -> Array | None:
        """Return the weight of each step of one run's epoch for each module.

        Args:
            run: Index of the run.
            epoch: The epoch, without features.

        Returns:
            Weights, shape (T, M); None where they are the responsibilities.
        """
        return None

    def logged(self) -> dict[str, Array]:
        """Return what is logged of each run's epoch beside its gains."""
        return {}

    @property
    def likely_plant(self) -> NDArray[np.intp] | int:
        """Index of the plant that is most probably on, shape (...)."""
        return 0

    def learn_context(self, run: RunIndex, context: Array) -> None:  # noqa: B027, a hook
        """Learn from the context of one run's whole episode, shape (T, C)."""

    def plants_of(self, run: RunIndex) -> int:
        """Return the number of plants that a run has recruited."""
        return 1

    def adapt(self, run: RunIndex, epoch: Epoch, readouts: Readouts) -> None:  # noqa: B027, a hook
        """Adapt one run's gate after its readouts have learned from an epoch."""

    @abstractmethod
    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""

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
            sigma: Width σ of the likelihood, in units of posture.
            uses_prior: Whether p is the predictors' output; otherwise 1.
            uses_likelihood: Whether ℓ depends on the prediction errors; otherwise 1.
        """
        self.predictor = networks.make("predictor", context_size, 1)
        self.enabled = np.ones(networks.modules, bool)
        self._sigma = sigma
        self._uses_prior, self._uses_likelihood = uses_prior, uses_likelihood
        # Random preferences for contexts, so that modules differ from the first step (choice).
        weights = self.predictor.readouts.weights  # (..., M, 1, F)
        for run in np.ndindex(np.shape(networks.seed)):
            seed = int(np.asarray(networks.seed)[run])
            drawn = stream(seed, "preference").random((networks.modules, context_size))
            weights[(*run, ..., 0, slice(networks.config.nodes, None))] = drawn

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors p and responsibilities λ of a step, each of shape (..., M)."""
        outputs = self.predictor.step(observation["context"])[..., 0]
        prior = clip(outputs, _LEAST_PRIOR, 1.0) if self._uses_prior else np.ones_like(outputs)
        prior *= self.enabled
        if predictions is None or not self._uses_likelihood:
            return prior, responsibilities(prior, np.ones_like(prior))
        errors = prediction_errors(predictions, observation["posture"])
        errors[..., ~self.enabled] = np.inf
        return prior, responsibilities(prior, likelihood(errors, self._sigma))

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's noise."""
        self.predictor.reset(episode)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self.predictor.select_runs(runs)

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return self.predictor.state_dict()

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self.predictor.load_state_dict(state)
