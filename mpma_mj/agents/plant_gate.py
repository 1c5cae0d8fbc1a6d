"""Gate in two levels: predictions tell plants apart, the context divides the motion inside a plant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation
from mpma_mj.agents.config import JOINTS
from mpma_mj.agents.gating import Gate
from mpma_mj.agents.networks import Network, NetworkFactory, RunIndex
from mpma_mj.agents.plant_models import PlantModels, gaussian_log_likelihood, plant_inputs
from mpma_mj.agents.switching import filtered, predicted
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.seeding import stream

if TYPE_CHECKING:
    from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts

__all__ = ["PlantGate", "balanced_preferences"]

Array = NDArray[np.float64]

_LEAST_PRIOR = 0.01  # p_min: no module is excluded for ever (choice)
_LEAST_VARIANCE = 1e-5  # of moves, under a module's own forward model (choice)
_LEAST_LOG = -30.0  # modules far behind the best are equal
_LEAST_SHARE = 1e-6  # so that a module that was never used can return (choice)
_BALANCING_ROUNDS, _SHARING_ROUNDS = 10, 3  # (choices)
_INHERITED_VISITS = 0.1  # weight of the parent's visits in a plant that is recruited (choice)


def balanced_preferences(shares: Array, visits: Array, sharpening: float) -> Array:
    """Compute preferences for labels from the shares that modules had of them (choice).

        p(c, k) ∝ L(c, k)^γ a_k        with a_k such that modules are used alike, Σ_c v_c p(c, k) = v / M

    γ > 1 sharpens the division; a_k balances usage (DeSieno 1988). Labels and modules are
    normalised in turn (Sinkhorn & Knopp 1967) for a few rounds.

    Args:
        shares: Mean responsibility L of each module for each label, shape (C, M).
        visits: How often each label occurred, v, shape (C,), with a sum above 0.
        sharpening: Exponent γ.

    Returns:
        Preferences, shape (C, M), that sum to 1 over modules.
    """
    preferences = np.maximum(shares, _LEAST_SHARE) ** sharpening
    for _ in range(_BALANCING_ROUNDS):
        preferences = preferences / (visits / visits.sum() @ preferences)
        preferences /= preferences.sum(axis=1, keepdims=True)
    return preferences


class PlantGate(Gate):
    """Responsibility of M modules for each of the plants recruited so far.

        b^w_t   ∝ ℓ^w_t [(1-h) b^w_{t-1} + h / W]                      which plant is on
        λ^{w,k} = b^w p^{w,k}(y) (ℓ^{w,k})^τ / Σ_k' p^{w,k'} (ℓ^{w,k'})^τ  which module inside it

    ℓ^w compares the last move with that of the plant model w, ℓ^{w,k} with that of the forward
    model of module k; both are Gaussians with measured widths. Priors p come from responsibility
    predictors, clipped to [0.01, 1] and normalised: reservoirs that M modules of all plants share,
    whose readouts decode the context, D z ≈ y, and preferences of each plant for its labels,
    p^{w,k} = P^w(:, k)ᵀ D^k z. A plant inherits the preferences of the plant that was taken for it.

    Attributes:
        plants: Plant models.
    """

    def __init__(
        self,
        networks: NetworkFactory,
        spec: AgentSpec,
        *,
        temperature: float,
        sharpening: float,
        uses_prior: bool = True,
        uses_likelihood: bool = True,
    ) -> None:
        """Draw the responsibility predictors.

        Args:
            networks: What the agent's networks have in common.
            spec: Description of arms and observations.
            temperature: Exponent τ.
            sharpening: Exponent γ of the preferences' target.
            uses_prior: Whether p is the predictors' output; otherwise 1 / M.
            uses_likelihood: Whether ℓ depend on predictions; otherwise 1.
        """
        self._spec, self._tau, self._sharpening = spec, temperature, sharpening
        self._uses_prior, self._uses_likelihood = uses_prior, uses_likelihood
        modules, labels, most = networks.modules, spec.context_size, networks.most_plants
        shape = np.shape(networks.seed)
        self._modules = modules
        self._predictor = networks.shared().make("predictor", labels, labels)
        decoder = self._predictor.readouts.weights  # (..., M, C, N + C)
        decoder[..., np.arange(labels), networks.config.nodes + np.arange(labels)] = 1.0
        self.plants = PlantModels.blank(shape, most)
        self._preferences = np.zeros((*shape, most, labels, modules))
        for run in np.ndindex(shape):
            seed = int(np.asarray(networks.seed)[run])
            drawn = stream(seed, "preference").random((modules, labels)).T
            self._preferences[(*run, 0)] = drawn
        self._visits = np.zeros((*shape, most, labels))
        self._variance = np.full((*shape, most * modules, JOINTS), 0.25)
        self.reset(0)

    @property
    def count(self) -> int:
        """Largest number of recruited plants in the batch."""
        return int(self.plants.recruited.max())

    def reset(self, episode: int) -> None:
        """Begin an episode with every plant alike, and reservoirs at rest."""
        self._predictor.reset(episode)
        self._enabled = np.arange(self.count) < self.plants.recruited[..., None]  # (..., W')
        self._belief = self._enabled / self._enabled.sum(axis=-1, keepdims=True)
        self._last: tuple[Array, Array] | None = None  # inputs o and joint angles q
        self._inputs: list[Array] = []

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors and responsibilities of a step, each of shape (..., W' · M)."""
        decoded = self._predictor.step(observation["context"])  # (..., M, C)
        inside = self._priors(decoded)  # (..., W', M)
        before = predicted(self._belief, self._enabled)
        prior = before[..., None] * inside
        self._belief = before
        learned = self._uses_likelihood and int(np.min(self.plants.epochs)) > 0
        if learned and predictions is not None and self._last is not None:
            move = self._spec.move(self._last[1], observation["joint_angles"])
            if self.count > 1:
                moves = (self.plants.weights[..., : self.count, :, :] @ self._last[0][..., None, :, None])[..., 0]
                errors = moves - move[..., None, :]
                logs = gaussian_log_likelihood(errors, self.plants.variance[..., : self.count, :])
                self._belief = filtered(before, logs)
            if self._tau and self._modules > 1:
                inside = inside * self._sharing(predictions - move[..., None, :], self._variance)
                inside = inside / inside.sum(axis=-1, keepdims=True)
        shape = (*prior.shape[:-2], -1)
        responsibility = self._belief[..., None] * inside
        return prior.reshape(shape), responsibility.reshape(shape)

    def observe_action(self, observation: Observation, action: Array) -> None:
        """Receive the action of a step."""
        angles, velocities = observation["joint_angles"], observation["joint_velocities"]
        inputs = plant_inputs(action, angles, velocities, self._spec.max_joint_speed)
        self._last = inputs, angles
        self._inputs.append(inputs)

    def assign(self, run: RunIndex, epoch: Epoch) -> Array:
        """Learn which plant was on and which module led; return who learns from each step.

        Returns:
            Weights, shape (T, W · M).
        """
        plants, most, modules = self.plants.of_run(run), self.plants.most, self._modules
        inputs = np.array([step[run] for step in self._inputs])
        learned = int(plants.epochs) > 0
        posterior, recruited = plants.learn(inputs, epoch.outcome)
        self._predictor.readouts.of_run(run).fit(
            self._predictor.episode(run), epoch.context[:, None, :]
        )
        preferences, visits = self._preferences[run], self._visits[run]
        if recruited:
            new = int(plants.recruited) - 1
            parent = int(posterior[:, :new].sum(axis=0).argmax())
            preferences[new] = preferences[parent]
            visits[new] = _INHERITED_VISITS * visits[parent]
        sharing = np.ones((len(inputs), most, modules))
        if learned and self._tau and self._uses_likelihood and modules > 1:
            errors = epoch.predictions - epoch.outcome[:, None]
            count = errors.shape[1] // modules
            sharing[:, :count] = self._sharing(errors, self._variance[run])
        weights = np.zeros_like(sharing)
        for w in np.flatnonzero(posterior.sum(axis=0) >= 1.0):
            own = posterior[:, w, None]
            labelled = epoch.context * own  # (T, C)
            seen = labelled.sum(axis=0)
            visits[w] += seen
            for _ in range(_SHARING_ROUNDS if modules > 1 and visits[w].any() else 0):
                led = self._led(epoch.context, preferences[w], sharing[:, w])
                share = np.where(
                    seen[:, None] > 0.5,
                    labelled.T @ led / np.maximum(seen, 1e-9)[:, None],
                    np.maximum(preferences[w], 1e-9),
                )
                share /= share.sum(axis=1, keepdims=True)
                preferences[w] = balanced_preferences(share, visits[w], self._sharpening)
            weights[:, w] = own * self._led(epoch.context, preferences[w], sharing[:, w])
        return weights.reshape(len(inputs), -1)

    def adapt(self, run: RunIndex, epoch: Epoch, rule: LearningRule, readouts: Readouts) -> None:
        """Measure the widths of the modules' forward models."""
        refitted = readouts.forward.outputs(epoch.forward_features)
        count = refitted.shape[1]
        weight = epoch.assignment[:, :count]
        total = weight.sum(axis=0)
        squares = np.einsum("tm,tmd->md", weight, (refitted - epoch.outcome[:, None]) ** 2)
        led = total >= 1.0
        self._variance[run][:count][led] = np.maximum(
            squares[led] / total[led, None], _LEAST_VARIANCE
        )

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._predictor.select_runs(runs)
        self.plants.select_runs(runs)
        self._preferences, self._visits = self._preferences[runs], self._visits[runs]
        self._variance = self._variance[runs]

    def drop_modules(self, modules: object) -> None:
        raise NotImplementedError

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state = self._predictor.state_dict()
        state |= {f"plants.{name}": array.copy() for name, array in vars(self.plants).items()}
        return state | {name: array.copy() for name, array in self._own().items()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self._predictor.load_state_dict(state)
        for name, array in vars(self.plants).items():
            array[...] = state[f"plants.{name}"]
        for name, array in self._own().items():
            array[...] = state[name]

    def _own(self) -> dict[str, Array]:
        return {
            "preferences": self._preferences,
            "visits": self._visits,
            "variance": self._variance,
        }

    def _priors(self, decoded: Array) -> Array:
        """Return priors inside each plant, shape (..., W', M), of decoded contexts (..., M, C)."""
        preferences = self._preferences[..., : self.count, :, :]  # (..., W', C, M)
        prior = (decoded[..., None, :, :] * preferences.swapaxes(-1, -2)).sum(axis=-1)
        if not self._uses_prior:
            return np.full_like(prior, 1.0 / self._modules)
        prior = clip(prior, _LEAST_PRIOR, 1.0)
        return prior / prior.sum(axis=-1, keepdims=True)

    def _led(self, context: Array, preferences: Array, sharing: Array) -> Array:
        """Return the shares of a plant's modules in each step, shape (T, M)."""
        share = clip(context @ preferences, _LEAST_PRIOR, 1.0) * sharing
        return share / share.sum(axis=1, keepdims=True)

    def _sharing(self, errors: Array, variance: Array) -> Array:
        """Return ℓ^τ of the modules' errors, (..., W' · M, 8), shape (..., W', M)."""
        logs = gaussian_log_likelihood(errors, variance[..., : errors.shape[-2], :])
        logs = self._tau * logs.reshape(*logs.shape[:-1], -1, self._modules)
        return np.exp(np.maximum(logs - logs.max(axis=-1, keepdims=True), _LEAST_LOG))
