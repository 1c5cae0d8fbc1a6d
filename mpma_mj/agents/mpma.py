"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Seeds
from mpma_mj.agents.config import NetworkConfig
from mpma_mj.agents.gated_models import GatedModels
from mpma_mj.agents.learning_rules import RULES, Epoch, Readouts
from mpma_mj.agents.paired_models import RunIndex
from mpma_mj.errors import BadOptionError
from mpma_mj.options import EfferenceCopy, RuleName

__all__ = ["MPMA", "MPMAConfig"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MPMAConfig(NetworkConfig):
    """Settings of the architecture: those of the networks, see `NetworkConfig`, and its own.

    Attributes:
        rule: "weighted" (ours) or "gated" (the paper's); see `learning`.
        efference_copy: Which command forward models hear: "total" that was taken, or each
            module's "module", as the paper's text says.
        responsibility_predictors: Whether it counts what they say; if not, all are as suited.
        forward_gating: Whether it counts whose forward model predicted well.

    Raises:
        BadOptionError: A setting is outside what it may be.
    """

    rule: RuleName = "weighted"
    efference_copy: EfferenceCopy = "total"
    responsibility_predictors: bool = True
    forward_gating: bool = True

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if self.rule not in get_args(RuleName):
            raise BadOptionError(f"rule is '{self.rule}'; expected weighted or gated")
        if self.efference_copy not in get_args(EfferenceCopy):
            raise BadOptionError(
                f"efference_copy is '{self.efference_copy}'; expected total or module"
            )


class MPMA(GatedModels):
    """Modules of inverse model, forward model and responsibility predictor that share a task.

    How they act is in `GatedModels` and `PairedModels`. After an epoch the learning rule
    refits all readouts.

    Attributes:
        config: Settings.
    """

    def __init__(self, config: MPMAConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings.
            spec: Where it acts.
            seed: Seed of weights and noise; several are agents side by side.
        """
        self.config = config
        self._rule = RULES[config.rule]
        super().__init__(
            config,
            spec,
            sigma=self._rule.first_sigma,
            seed=seed,
            forgetting=self._rule.forgetting,
        )

    def _prior(self, said: Array) -> Array:
        heeded = self.config.responsibility_predictors
        return super()._prior(said) if heeded else np.ones_like(said)

    def _likelihood(self, errors: Array) -> Array:
        heeded = self.config.forward_gating
        return super()._likelihood(errors) if heeded else np.ones_like(errors)

    def _efference_copy(self, action: Array, module_actions: Array) -> Array:
        return action if self.config.efference_copy == "total" else module_actions

    def _learners(self, run: RunIndex) -> Readouts:
        """Return the readouts that learn, of one run."""
        return self._readouts.of_run(run)

    def _learn_epoch(self, run: RunIndex, episode: dict[str, Array]) -> dict[str, float]:
        """Refit all readouts; log the σ of the episode."""
        epoch, sigma = Epoch.of(episode), float(self._sigma[run])
        self._rule.fit(self._learners(run), epoch)
        self._sigma[run] = self._rule.next_sigma(epoch, sigma)
        return {"sigma": sigma}
