"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008, and a single pair."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Seeds
from mpma_mj.agents.config import AgentConfig, MPMAConfig, SingleConfig
from mpma_mj.agents.gating import ResponsibilityGate
from mpma_mj.agents.learning_rules import TwoLevelRule, learning_rule
from mpma_mj.agents.model_space import JointSpace, PostureSpace
from mpma_mj.agents.plant_gate import PlantGate
from mpma_mj.esn import Ridge
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.paired_models import PairedModels

__all__ = ["MPMA", "Single"]

Array = NDArray[np.float64]


class MPMA(PairedModels):
    """Modules of inverse model, forward model and responsibility predictor that share control.

    `PairedModels` with a `ResponsibilityGate` and the weighted, the gated or an outside rule.
    """

    config_type: ClassVar[type[AgentConfig]] = MPMAConfig
    _gate: ResponsibilityGate

    def __init__(
        self,
        config: MPMAConfig,
        spec: AgentSpec,
        *,
        seed: Seeds = 0,
        gate_type: type[ResponsibilityGate] = ResponsibilityGate,
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Config.
            spec: Description of arms and observations.
            seed: Seed of weights and noise; several are a batch of runs.
            gate_type: Class of the gate.

        Raises:
            BadOptionError: The rule cannot be imported.
        """
        if config.models == "joint":
            rule = TwoLevelRule()
            networks = NetworkFactory(
                config, seed, config.modules, rule.forgetting, 1e-4, config.max_plants
            )
            gate = PlantGate(
                networks,
                spec,
                temperature=0.1,
                sharpening=3.0,
                uses_prior=config.responsibility_predictors,
                uses_likelihood=config.forward_gating,
            )
            space = JointSpace(spec)
            super().__init__(
                config, spec, networks=networks, gate=gate, rule=rule, space=space,
                inverse_ridge=Ridge(1e-6, 0.03),
            )
            return
        rule = learning_rule(config.rule)
        networks = NetworkFactory(config, seed, config.modules, rule.forgetting, config.ridge)
        gate = gate_type(
            networks,
            spec.context_size,
            sigma=rule.first_sigma,
            uses_prior=config.responsibility_predictors,
            uses_likelihood=config.forward_gating,
        )
        copy = config.efference_copy
        super().__init__(config, spec, networks=networks, gate=gate, rule=rule, efference_copy=copy, space=PostureSpace(spec, proprioception=config.proprioception))

    def learn(self) -> dict[str, Array]:
        """Let every run learn from its episode; log also the σ of the episode, `sigma`."""
        if isinstance(self._gate, PlantGate):
            plants = self._gate.plants.recruited.copy()
            return super().learn() | {"plants": plants}
        sigma = self._gate.sigma.copy()
        return super().learn() | {"sigma": sigma}


class Single(MPMA):
    """One pair of inverse and forward model: MPMA of one module."""

    config_type: ClassVar[type[AgentConfig]] = SingleConfig
    has_modules: bool = False

    def __init__(self, config: SingleConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs; see `MPMA`."""
        super().__init__(MPMAConfig(**vars(config), modules=1), spec, seed=seed)
        self.config = config
