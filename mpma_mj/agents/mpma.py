"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008, and two variants of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation, Seeds
from mpma_mj.agents.config import AgentConfig, MPMAConfig, OracleConfig, SingleConfig, check_models
from mpma_mj.agents.gating import Gate, ResponsibilityGate
from mpma_mj.agents.late_senses import LateSenses
from mpma_mj.agents.learning_rules import learning_rule
from mpma_mj.agents.model_space import model_space
from mpma_mj.agents.networks import NetworkFactory, RunIndex
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.agents.plant_gate import PlantGate
from mpma_mj.agents.plant_models import PlantModels
from mpma_mj.agents.senses import ModelledSenses, Senses
from mpma_mj.errors import BadOptionError

__all__ = ["MPMA", "Oracle", "Single"]

Array = NDArray[np.float64]


class MPMA(PairedModels):
    """Modules of inverse model, forward model and responsibility predictor that share control.

    With joint models (ours) `PairedModels` in a `JointSpace` with a `PlantGate` and the weighted
    rule; with posture models (the paper's) in a `PostureSpace` with a `ResponsibilityGate` and the
    gated rule. Rules from outside declare which models they are made for.
    """

    config_type: ClassVar[type[AgentConfig]] = MPMAConfig
    gate_type: ClassVar[type[PlantGate]] = PlantGate

    def __init__(self, config: MPMAConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs.

        Args:
            config: Config.
            spec: Description of arms and observations.
            seed: Seed of weights and noise; several are a batch of runs.

        Raises:
            BadOptionError: The rule cannot be imported, or is made for other models.
        """
        rule = learning_rule(config.rule)
        check_models(config.rule, rule.models, config.models)
        joint = config.models == "joint"
        networks = NetworkFactory.fitted(config, seed, config.modules, rule.forgetting)
        senses = _senses(config, spec, seed) if joint else None
        gate: Gate
        if joint:
            networks = replace(networks, max_plants=config.max_plants)
            late = senses is not None and senses.late
            gate = self.gate_type(networks, config, spec, guarded_recruitment=late)
        else:
            gate = ResponsibilityGate(
                networks,
                spec.context_size,
                sigma=rule.sigma,
                uses_prior=config.responsibility_predictors,
                uses_likelihood=config.forward_gating,
            )
        super().__init__(
            config,
            spec,
            networks=networks,
            gate=gate,
            rule=rule,
            space=model_space(config, spec),
            senses=senses,
            efference_copy=config.efference_copy,
        )


def _is_late(config: MPMAConfig, spec: AgentSpec) -> bool:
    """Return whether a latency is compensated."""
    return config.max_latency > 0 and spec.latency != 0


def _senses(config: MPMAConfig, spec: AgentSpec, seed: Seeds) -> Senses | None:
    """Return the senses of joint models; None where models of the state are not learned.

    Raises:
        BadOptionError: The latency is beyond the largest that is compensated, or the history of
            moves, which is late, is among the inputs.
    """
    late = _is_late(config, spec)
    if not (late or config.state_estimate):
        modelled = config.max_latency > 0 and not config.history
        shape = np.shape(seed)
        return ModelledSenses(spec, shape, config.max_plants) if modelled else None
    if late and spec.longest_latency > config.max_latency:
        expected = f"at least {spec.longest_latency}, the latency of the environment, or 0"
        raise BadOptionError(option="max_latency", value=config.max_latency, expected=expected)
    if config.history:
        remedy = (
            "its moves are late: leave it out, or choose {max_latency=0} without {state_estimate}"
        )
        raise BadOptionError(option="history", value=True, remedy=remedy)
    known = spec.latency if late else 0
    return LateSenses(
        replace(spec, latency=known),
        np.shape(seed),
        plants=config.max_plants,
        max_latency=config.max_latency,
        estimates=config.state_estimate,
        seed=seed,
    )


class Single(MPMA):
    """One pair of inverse and forward model: MPMA of one module and one plant."""

    config_type: ClassVar[type[AgentConfig]] = SingleConfig
    has_modules: bool = False

    def __init__(self, config: SingleConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs; see `MPMA`."""
        alone: dict[str, Any] = {"max_plants": 1} if config.models == "joint" else {}
        super().__init__(MPMAConfig(**vars(config), modules=1, **alone), spec, seed=seed)
        self.config = config


class _ObservingGate(PlantGate):
    """`PlantGate` that receives the plant instead of a belief, and has modules for all of them.

    Attributes:
        true_plant: Index of the plant that is on, shape (...); the first until it is given.
    """

    true_plant: NDArray[np.intp]

    def __init__(self, *args: Any, **options: Any) -> None:
        """Draw the responsibility predictors, and let all plants prefer alike."""
        super().__init__(*args, **options)
        self.models.recruited[...] = self.models.most
        self._preferences[...] = self._preferences[..., :1, :, :]
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self.true_plant = np.zeros_like(self.models.recruited)
        self._true_plants: list[NDArray[np.intp]] = []

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors and responsibilities of a step, each of shape (..., W · M)."""
        self._true_plants.append(self.true_plant)
        self._possible = self.true_plant[..., None] == np.arange(self.plants)
        self._belief = self._possible.astype(float)
        return super().__call__(observation, predictions)

    def _posterior(
        self, run: RunIndex, models: PlantModels, inputs: Array, outcome: Array
    ) -> Array:
        """Return which plant was on in each step of one run, shape (T, W)."""
        models.epochs[...] += 1
        # Where senses are late, no command acted in the first steps.
        plants = np.array([step[run] for step in self._true_plants])[-len(outcome) :]
        return (plants[:, None] == np.arange(models.most)).astype(float)

    def _believed(self, before: Array, move: Array) -> Array:
        """Return the belief b, which no move changes."""
        return before


class Oracle(MPMA):
    """`MPMA` that observes which plant is on, and has a set of modules for each."""

    config_type: ClassVar[type[AgentConfig]] = OracleConfig
    gate_type: ClassVar[type[PlantGate]] = _ObservingGate
    observes_plant: bool = True
    _gate: _ObservingGate

    def observe_plant(self, plant: NDArray[np.intp] | None) -> None:
        """Receive the index of the plant that is on, shape (...), before each action.

        Raises:
            BadOptionError: There are more plants than the agent may have.
        """
        true_plant = np.zeros(self._batch_shape, np.intp) if plant is None else np.asarray(plant)
        number, most = int(true_plant.max()) + 1, self._gate.models.most
        if number > most:
            expected = f"at least {number}, one for each plant of the environment"
            raise BadOptionError(option="max_plants", value=most, expected=expected)
        self._gate.true_plant = true_plant
