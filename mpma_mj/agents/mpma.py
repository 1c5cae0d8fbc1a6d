"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent import Seeds
from mpma_mj.agents.arena import Arena
from mpma_mj.agents.learning import RULES, Epoch, Readouts
from mpma_mj.agents.networks import PairsConfig
from mpma_mj.agents.pairs import Member
from mpma_mj.agents.responsible import ResponsiblePairs
from mpma_mj.errors import BadOptionError
from mpma_mj.options import ForwardInput, RuleName

__all__ = ["MPMA", "MPMAConfig"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MPMAConfig(PairsConfig):
    """Settings of the architecture: those of the networks, see `PairsConfig`, and its own.

    Attributes:
        rule: "weighted" (ours) or "gated" (the paper's); see `learning`.
        forward_input: Which command forward models hear: "total" that was taken, or each
            module's "own", as the paper's text says.
        responsibility_predictors: Whether it counts what they say; if not, all are as suited.
        forward_gating: Whether it counts whose forward model predicted well.

    Raises:
        BadOptionError: A setting is outside what it may be.
    """

    rule: RuleName = "weighted"
    forward_input: ForwardInput = "total"
    responsibility_predictors: bool = True
    forward_gating: bool = True

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if self.rule not in get_args(RuleName):
            raise BadOptionError(f"rule is '{self.rule}'; expected weighted or gated")
        if self.forward_input not in get_args(ForwardInput):
            raise BadOptionError(f"forward_input is '{self.forward_input}'; expected total or own")


class MPMA(ResponsiblePairs):
    """Modules of inverse model, forward model and responsibility predictor that share a task.

    How they act is in `ResponsiblePairs` and `PairsAgent`. After an epoch the learning rule
    refits all readouts.

    Attributes:
        config: Settings.
    """

    def __init__(self, config: MPMAConfig, arena: Arena, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings.
            arena: Where it acts.
            seed: Seed of weights and noise; several are agents side by side.
        """
        self.config = config
        self._rule = RULES[config.rule]
        super().__init__(
            config,
            arena,
            sigma=self._rule.first_sigma,
            seed=seed,
            forgetting=self._rule.forgetting,
        )

    def _suited(self, said: Array) -> Array:
        heeded = self.config.responsibility_predictors
        return super()._suited(said) if heeded else np.ones_like(said)

    def _likelihood(self, errors: Array) -> Array:
        heeded = self.config.forward_gating
        return super()._likelihood(errors) if heeded else np.ones_like(errors)

    def _heard(self, action: Array, module_actions: Array) -> Array:
        return action if self.config.forward_input == "total" else module_actions

    def _learners(self, member: Member) -> Readouts:
        """Return the readouts that learn, of one member."""
        return self._readouts.member(member)

    def _learn_epoch(self, member: Member, episode: dict[str, Array]) -> dict[str, float]:
        """Refit all readouts; log the σ of the episode."""
        epoch, sigma = Epoch.of(episode), float(self._sigma[member])
        self._rule.fit(self._learners(member), epoch)
        self._sigma[member] = self._rule.next_sigma(epoch, sigma)
        return {"sigma": sigma}
