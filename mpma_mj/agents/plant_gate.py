"""Gate in two levels: plants by prediction errors, modules inside a plant by the context."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation
from mpma_mj.agents.config import JOINTS, MPMAConfig
from mpma_mj.agents.gating import LEAST_SHARE, Gate, balanced_preferences
from mpma_mj.agents.networks import NetworkFactory, RunIndex
from mpma_mj.agents.plant_models import PlantModels, gaussian_log_likelihood, plant_inputs
from mpma_mj.agents.switching import filtered, predicted
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.saved_arrays import assign
from mpma_mj.utils.seeding import stream

if TYPE_CHECKING:
    from mpma_mj.agents.learning_rules import Epoch, Readouts

__all__ = ["PlantGate"]

Array = NDArray[np.float64]

# Three widths: where every module of a plant is far off, as in a plant never met, they are alike
# and the context decides. Without it they share at random there (choice).
_CAP = 9.0
_SHARPENING = 3.0  # γ (choice)
_LEAST_PRIOR = np.array(0.01)  # p_min: no module is excluded for ever (choice)
# Of moves, under a module's own forward model (choices).
_FIRST_VARIANCE, _LEAST_VARIANCE = 0.25, 1e-5
_LEAST_LOG = np.array(-30.0)  # modules far behind the best are equal
_SHARING_ROUNDS = 3  # (choice)
_SEEN = 0.5  # steps of a label from which a module's share of it is known (choice)
_TINY = np.array(np.finfo(np.float64).tiny)
_INHERITED_VISITS = 0.1  # weight of the parent's visits in a plant that is recruited (choice)


class PlantGate(Gate):
    """Responsibility of M modules for each of the plants recruited so far.

        b^w_t   ∝ ℓ^w_t [(1-h) b^w_{t-1} + h / W]                      which plant is on
        λ^{w,k} = b^w p^{w,k}(y) (ℓ^{w,k})^τ / Σ_k' p^{w,k'} (ℓ^{w,k'})^τ  which module inside it

    ℓ^w compares the last move with that of the plant model w, ℓ^{w,k} with that of the forward
    model of module k; both are Gaussians with measured widths. Priors p come from responsibility
    predictors, clipped to [0.01, 1] and normalised: reservoirs that M modules of all plants share,
    whose readouts decode the context, D z ≈ y, and preferences of each plant for its labels,
    p^{w,k} = P^w(:, k)ᵀ D^k z. A plant inherits the preferences of the plant that was taken for it,
    and where recruitment is guarded, modules of others learn nothing in that epoch (`PlantModels`).

    Attributes:
        models: Plant models.
    """

    compares_postures: ClassVar[bool] = False

    def __init__(
        self,
        networks: NetworkFactory,
        config: MPMAConfig,
        spec: AgentSpec,
        *,
        guarded_recruitment: bool = False,
    ) -> None:
        """Draw the responsibility predictors.

        Args:
            networks: What the agent's networks have in common.
            config: Config of the agent.
            spec: Description of arms and observations.
            guarded_recruitment: Whether a new plant inherits sums and learns alone.
        """
        self._config, self._spec = config, spec
        modules, labels, most = networks.modules, spec.context_size, networks.max_plants
        shape = np.shape(networks.seed)
        self._modules = modules
        self.enabled = np.ones(most * modules, bool)
        self._predictor = networks.make_shared("predictor", labels, labels)
        decoder = self._predictor.readouts.weights  # (..., M, C, N + C)
        decoder[..., np.arange(labels), networks.config.nodes + np.arange(labels)] = 1.0
        self.models = PlantModels(
            shape,
            most=most,
            novelty=config.novelty,
            switching_probability=config.switching_probability,
            guarded_recruitment=guarded_recruitment,
        )
        self._preferences = np.zeros((*shape, most, labels, modules))
        for run in np.ndindex(shape):
            seed = int(np.asarray(networks.seed)[run])
            drawn = stream(seed, "preference").random((modules, labels)).T
            self._preferences[(*run, 0)] = drawn
        self._visits = np.zeros((*shape, most, labels))
        self._variance = np.full((*shape, most * modules, JOINTS), _FIRST_VARIANCE)
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with every plant alike, and reservoirs at rest."""
        self._predictor.reset(episode)
        self.plants = int(self.models.recruited.max())
        self._present = self.models.recruited.copy()  # plants of each run in this episode
        self._allow()
        self._belief = _uniform_belief(self._possible)
        self._whole = _uniform_belief(self._recruited) if self._hidden.any() else None
        # Before the first epoch predictions carry no information.
        self._compares = self._config.forward_gating and int(self.models.epochs.min()) > 0
        self._angles: Array | None = None  # of the step before, as the plant models' inputs
        self._inputs: Array | None = None

    def enable(self, mask: NDArray[np.bool_]) -> None:
        """Switch modules off or on, from the next step, by a mask of shape (W · M,).

        Where all of a plant are off, the belief is updated among the others; meanwhile the belief
        among all plants is, too.
        """
        whole = self._belief if self._whole is None else self._whole
        super().enable(mask)
        self._allow()
        hides = self._hidden.any(axis=-1, keepdims=True)
        self._whole = whole if hides.any() else None
        self._belief = np.where(hides, _normalised(whole * self._possible), whole)

    def _allow(self) -> None:
        """Let modules that are enabled lead, and plants with such modules be possible."""
        allowed = self.enabled[: self.plants * self._modules].reshape(self.plants, -1)
        self._allowed = allowed.astype(np.float64)  # (W', M)
        self._recruited = np.arange(self.plants) < self._present[..., None]  # (..., W')
        self._possible = self._recruited & allowed.any(axis=-1)
        self._hidden = self._recruited & ~self._possible

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors and responsibilities of a step, each of shape (..., W' · M)."""
        inside = self._priors(self._predictor.step(observation["context"]))  # (..., W', M)
        move = sharing = None
        if predictions is not None and self._angles is not None and self._compares:
            move = self._spec.move(self._angles, observation["joint_angles"])[..., None, :]
            if self._modules > 1:
                sharing = self._sharing(predictions - move, self._variance)
        before, self._belief = self._updated(self._belief, self._possible, move)
        if self._whole is not None:
            _, self._whole = self._updated(self._whole, self._recruited, move)
        prior = _of_plants(before, inside)
        if sharing is not None:
            inside = _normalised(inside * sharing)
        return prior, _of_plants(self._belief, inside)

    def observe_action(self, joint_angles: Array, state: Array, action: Array) -> None:
        """Receive joint angles, (..., 8), rad, proprioceptive state, (..., S), and action."""
        self._angles = joint_angles
        if self.plants > 1:
            self._inputs = plant_inputs(action, state)

    def assign(self, run: RunIndex, epoch: Epoch) -> Array:
        """Learn which plant was on and which module led; return the weights of learning.

        Args:
            run: Index of the run.
            epoch: The epoch, without features.

        Returns:
            Weights, shape (T, W · M), that sum to 1 over the modules; 0 where one is switched
            off, or of another plant than one whose recruitment is guarded.
        """
        models, modules, context = self.models.of_run(run), self._modules, epoch.context
        sharing = np.ones((len(context), models.most, modules))
        if modules > 1 and self._compares:
            count = int(self._present[run])
            errors = epoch.predictions[:, : count * modules] - epoch.outcome[:, None]
            sharing[:, :count] = self._sharing(errors, self._variance[run])
        inputs = plant_inputs(epoch.action, epoch.state)
        posterior = self._posterior(run, models, inputs, epoch.outcome)
        weights, enabled = np.zeros_like(sharing), self.enabled.reshape(-1, modules)
        for plant in np.flatnonzero(posterior.sum(axis=0) >= 1.0).tolist():
            own = posterior[:, plant, None]
            if enabled[plant].all():  # else the division of the plant's motion stays
                self._prefer((*run, plant), own * context, context, sharing[:, plant])
            preferences = self._preferences[(*run, plant)]
            taking_part = sharing[:, plant] * enabled[plant]
            weights[:, plant] = own * _led(context, preferences, taking_part)
        return weights.reshape(len(weights), -1)

    @property
    def likely_plant(self) -> NDArray[np.intp]:
        """Index of the plant that is most probably on, shape (...)."""
        return np.asarray(self._belief.argmax(axis=-1))

    def learn_context(self, run: RunIndex, context: Array) -> None:
        """Fit the decoders of one run to the context of its whole episode, shape (T, C)."""
        features = self._predictor.episode(run, self._modules)
        self._predictor.readouts.of_run(run).fit(features, context[:, None, :])

    def logged(self) -> dict[str, Array]:
        """Return what is logged of each run: whether it calibrates, and its number of plants."""
        return {
            "calibrating": self.models.calibrating.astype(float),
            "plants": self.models.recruited.astype(float),
        }

    def plants_of(self, run: RunIndex) -> int:
        """Return the number of plants that a run has recruited."""
        return int(self.models.recruited[run])

    def _posterior(
        self, run: RunIndex, models: PlantModels, inputs: Array, outcome: Array
    ) -> Array:
        """Let the plant models of one run learn; return plant weights of all steps, (T, W)."""
        posterior, is_new = models.learn(inputs, outcome)
        if is_new:
            new = int(models.recruited) - 1
            self._inherit(run, posterior, new)
            if models.guarded_recruitment:
                posterior[:, :new] = 0.0
        return posterior

    def _inherit(self, run: RunIndex, posterior: Array, new: int) -> None:
        """Let a new plant begin with the preferences of the plant that was taken for it."""
        parent = int(posterior[:, :new].sum(axis=0).argmax())
        self._preferences[(*run, new)] = self._preferences[(*run, parent)]
        self._visits[(*run, new)] = _INHERITED_VISITS * self._visits[(*run, parent)]

    def _prefer(self, plant: RunIndex, labelled: Array, context: Array, sharing: Array) -> None:
        """Let the modules of a plant prefer the labels of which they had most.

        Args:
            plant: Index of run and plant.
            labelled: Context, weighted with the plant's posterior, shape (T, C).
            context: Context, shape (T, C).
            sharing: ℓ^τ of the modules, shape (T, M).
        """
        seen = labelled.sum(axis=0)
        visits = self._visits[plant]
        visits += seen
        if self._modules == 1 or not visits.any():
            return
        for _ in range(_SHARING_ROUNDS):
            preferences = self._preferences[plant]
            led = labelled.T @ _led(context, preferences, sharing)  # (C, M)
            share = np.where(seen[:, None] > _SEEN, led, np.maximum(preferences, LEAST_SHARE))
            balanced = balanced_preferences(_normalised(share), visits, _SHARPENING)
            self._preferences[plant] = balanced

    def adapt(self, run: RunIndex, epoch: Epoch, readouts: Readouts) -> None:
        """Measure the widths of the modules' forward models.

        Errors are those of the predictions in the epoch, before the models learned from it: after
        it they are too small by far, as a module has few steps. Modules of a plant that was just
        recruited have predicted nothing yet.
        """
        count = int(self._present[run]) * self._modules
        errors = epoch.predictions[:, :count] - epoch.outcome[:, None]
        weight = epoch.assignment[:, :count]
        total = weight.sum(axis=0)[:, None]
        squares = np.einsum("tm,tmd->md", weight, errors**2) / np.maximum(total, 1.0)
        own = self._variance[run][:count]
        own[:] = np.where(total >= 1.0, np.maximum(squares, _LEAST_VARIANCE), own)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._predictor.select_runs(runs)
        self.models.select_runs(runs)
        self._preferences, self._visits = self._preferences[runs], self._visits[runs]
        self._variance = self._variance[runs]

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        state = self._predictor.state_dict()
        state |= {f"plants.{name}": array.copy() for name, array in self.models.arrays().items()}
        return state | {name: array.copy() for name, array in self._own().items()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self._predictor.load_state_dict(state)
        assign(self.models.recruited, state["plants.recruited"], low=1, high=self.models.most)
        for name, array in self.models.arrays().items():
            assign(array, state[f"plants.{name}"])
        for name, array in self._own().items():
            assign(array, state[name])
        self.plants = int(self.models.recruited.max())

    def _own(self) -> dict[str, Array]:
        return {
            "preferences": self._preferences,
            "visits": self._visits,
            "variance": self._variance,
        }

    def _updated(
        self, belief: Array, possible: NDArray[np.bool_], move: Array | None
    ) -> tuple[Array, Array]:
        """Return the belief b before and after a move, each (..., W'), among possible plants."""
        before = predicted(belief, possible, self._config.switching_probability)
        if move is None or self.plants == 1:
            return before, before
        return before, self._believed(before, move)

    def _believed(self, before: Array, move: Array) -> Array:
        """Return the belief b after a move, shape (..., 1, 8), from that before, (..., W')."""
        assert self._inputs is not None
        errors = self.models.moves(self._inputs, self.plants) - move
        variance = self.models.variance[..., : self.plants, :]
        return filtered(before, gaussian_log_likelihood(errors, variance))

    def _priors(self, decoded: Array) -> Array:
        """Return priors inside each plant, shape (..., W', M), of decoded contexts (..., M, C)."""
        preferences = self._preferences[..., : self.plants, :, :].swapaxes(-1, -2)
        prior = np.vecdot(decoded[..., None, :, :], preferences)  # (..., W', M)
        if not self._config.responsibility_predictors:
            prior = np.ones_like(prior)
        return _normalised(clip(prior, _LEAST_PRIOR) * self._allowed)

    def _sharing(self, errors: Array, variance: Array) -> Array:
        """Return ℓ^τ of the modules' errors, (..., W' · M, 8), shape (..., W', M)."""
        logs = gaussian_log_likelihood(errors, variance[..., : errors.shape[-2], :], _CAP)
        logs = self._config.temperature * logs.reshape(*logs.shape[:-1], -1, self._modules)
        return np.exp(np.maximum(logs - logs.max(axis=-1, keepdims=True), _LEAST_LOG))


def _led(context: Array, preferences: Array, sharing: Array) -> Array:
    """Return the share of each module of a plant in the steps of an epoch, shape (T, M)."""
    return _normalised(clip(context @ preferences, _LEAST_PRIOR) * sharing)


def _of_plants(belief: Array, inside: Array) -> Array:
    """Return b^w p^{w,k}, shape (..., W' · M), of beliefs (..., W') and priors (..., W', M)."""
    if belief.shape[-1] > 1:  # else b = 1, or 0 with all priors
        inside = belief[..., None] * inside
    return inside.reshape(*inside.shape[:-2], -1)


def _uniform_belief(possible: NDArray[np.bool_]) -> Array:
    """Return the belief in plants, (..., W'), before anything is known."""
    return possible / np.maximum(possible.sum(axis=-1, keepdims=True), 1)


def _normalised(shares: Array) -> Array:
    """Return shares, (..., M), that sum to 1; 0 where all are 0."""
    return shares / np.maximum(np.add.reduce(shares, axis=-1, keepdims=True), _TINY)
