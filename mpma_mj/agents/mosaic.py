"""MOSAIC of Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001."""

from __future__ import annotations

from dataclasses import dataclass

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Seeds
from mpma_mj.agents.config import NetworkConfig
from mpma_mj.agents.gated_models import GatedModels
from mpma_mj.agents.paired_models import RunIndex
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import is_number

__all__ = ["MOSAIC", "LearningRates"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearningRates:
    """Learning rates η of normalised LMS, of MOSAIC's three kinds of networks (choice).

    Attributes:
        forward: Of the forward models.
        inverse: Of the inverse models.
        predictor: Of the responsibility predictors.

    Raises:
        BadOptionError: A rate is not between 0 and 2, where the error would grow.
    """

    forward: float = 0.2
    inverse: float = 0.2
    predictor: float = 0.1

    def __post_init__(self) -> None:
        """Check the rates."""
        for name, rate in vars(self).items():
            if not (is_number(rate) and 0.0 < float(rate) < 2.0):
                raise BadOptionError(f"rate '{name}' is {rate!r}; expected between 0 and 2")


class MOSAIC(GatedModels):
    """Modules of forward and inverse model that learn at every step, gated by responsibility.

    The command, the responsibilities λ and the schedule of the gains K and L are MPMA's, so that
    both are compared on equal terms (choice). Every forward model hears the total command. As
    soon as an action has shown what it leads to, every readout moves along its error e,

        W_out,i ← W_out,i + η e zᵀ / (ε + zᵀz)

        forward models           e = λ^i (x_{t+1} - x̂^i_{t+1})
        inverse models           e = λ^i (K u_fb)_{t+1}
        responsibility pred.     e = λ^i - RP_i(y)

    the second being feedback-error learning (Kawato 1990): what the feedback controller has to
    add to the command's outcome is the command's error. Since it learns while it dances, the
    state that a trainer keeps is the one at the beginning of an epoch.

    σ stays (choice). At 0.5, where MPMA's weighted rule begins, the likelihood says little and the
    context decides; at 0.144 one module wins everything; and if σ follows the prediction error, as
    under that rule, modules divide inside labels, which predictors cannot tell by context.
    """

    def __init__(
        self,
        config: NetworkConfig,
        spec: AgentSpec,
        *,
        seed: Seeds = 0,
        rates: LearningRates = LearningRates(),
        sigma: float = 0.5,
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings of the networks.
            spec: Where it acts.
            seed: Seed of weights and noise; several are agents side by side.
            rates: Learning rates.
            sigma: Width σ of the likelihood, in units of posture.

        Raises:
            BadOptionError: σ is not above 0.
        """
        if not (is_number(sigma) and float(sigma) > 0.0):
            raise BadOptionError(f"sigma is {sigma!r}; expected above 0")
        self._rates = rates
        super().__init__(config, spec, sigma=sigma, seed=seed)

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take in what the action led to, and learn from it."""
        super().observe(timestep)
        if not len(self._steps):  # an episode has begun
            return
        step, last, readouts = self._steps[-1], self._last, self._readouts
        gate = step["responsibility"][..., None]  # (..., M, 1)
        surprise = last["posture"][..., None, :] - step["predictions"]
        feedback = self._spec.feedback(last["joint_angles"], last["reference"])
        correction = (step["feedback_gain"][..., None] * feedback)[..., None, :]  # (..., 1, 8)
        said = readouts.predictor(step["predictor_features"])  # (..., M, 1)
        rates = self._rates
        readouts.forward.partial_fit(step["forward_features"], gate * surprise, rates.forward)
        readouts.inverse.partial_fit(step["inverse_features"], gate * correction, rates.inverse)
        readouts.predictor.partial_fit(step["predictor_features"], gate - said, rates.predictor)

    def _efference_copy(self, action: Array, module_actions: Array) -> Array:
        return action

    def _learn_epoch(self, run: RunIndex, episode: dict[str, Array]) -> dict[str, float]:
        """Learn nothing: all has been learned step by step."""
        return {}
