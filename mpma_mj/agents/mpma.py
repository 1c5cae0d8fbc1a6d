"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008, and a single pair."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Seeds
from mpma_mj.agents.config import AgentConfig, MPMAConfig, SingleConfig, check_models
from mpma_mj.agents.gating import Gate, ResponsibilityGate
from mpma_mj.agents.late_senses import LateSenses
from mpma_mj.agents.learning_rules import learning_rule
from mpma_mj.agents.model_space import model_space
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.agents.plant_gate import PlantGate
from mpma_mj.agents.senses import ModelledSenses, Senses
from mpma_mj.errors import BadOptionError

__all__ = ["MPMA", "Single"]

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
        networks = NetworkFactory(
            config=config,
            seed=seed,
            modules=config.modules,
            forgetting=rule.forgetting,
            ridge=config.ridge,
            inverse_ridge=config.inverse_ridge if joint else 0.0,
            max_plants=config.max_plants if joint else 1,
        )
        senses = _senses(config, spec, seed) if joint else None
        gate: Gate
        if joint:
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

    def learn(self) -> dict[str, Array]:
        """Let every run learn from its episode.

        Returns:
            Gains; of joint models also whether they are `calibrating` and the number of `plants`.
        """
        logged = super().learn()
        return logged | self._gate.logged() if isinstance(self._gate, PlantGate) else logged


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
