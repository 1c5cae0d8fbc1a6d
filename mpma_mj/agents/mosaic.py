"""MOSAIC of Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001."""

from __future__ import annotations

from dataclasses import dataclass

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.learning import WeightedRule
from mpma_mj.agents.pairs import PairsConfig
from mpma_mj.agents.responsible import ResponsiblePairs
from mpma_mj.errors import BadOptionError

__all__ = ["MOSAIC", "LearningRates"]

Array = NDArray[np.float64]

_WIDTH = WeightedRule()  # σ follows the prediction error as under our rule (choice)


@dataclass(frozen=True)
class LearningRates:
    """Learning rates η of normalised LMS, of MOSAIC's three kinds of networks (choice).

    Attributes:
        forward: Of the forward models; twice as much or more, and one module wins everything.
        inverse: Of the inverse models.
        predictor: Of the responsibility predictors; with less they do not keep up with λ.

    Raises:
        BadOptionError: A rate is not between 0 and 2, where the error would grow.
    """

    forward: float = 0.2
    inverse: float = 0.5
    predictor: float = 0.3

    def __post_init__(self) -> None:
        """Check the rates."""
        for name, rate in vars(self).items():
            if not 0.0 < rate < 2.0:
                raise BadOptionError(f"rate '{name}' is {rate:g}; expected between 0 and 2")


class MOSAIC(ResponsiblePairs):
    """Modules of forward and inverse model that learn at every step, gated by responsibility.

    The command, the responsibilities λ and the schedule of the gains K and L are MPMA's, so that
    both are compared on equal terms (choice). Every forward model hears the total command. As
    soon as an action has shown what it leads to, every readout moves along its error e,

        W_out,i ← W_out,i + η e zᵀ / (ε + zᵀz)

        forward models           e = λ^i (x_{t+1} - x̂^i_{t+1})
        inverse models           e = λ^i (K u_fb)_{t+1}
        responsibility pred.     e = λ^i - p^i

    the second being feedback-error learning (Kawato 1990): what the feedback controller has to
    add to the command's outcome is the command's error. Since it learns while it dances, the
    state that a trainer keeps is the one at the beginning of an epoch.
    """

    def __init__(
        self,
        config: PairsConfig,
        *,
        context_size: int,
        max_joint_speed: Array,
        control_timestep: float,
        seed: int = 0,
        rates: LearningRates = LearningRates(),
    ) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings of the networks.
            context_size: Size of the observation's context, C.
            max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
            control_timestep: Time between two actions, s.
            seed: Seed of weights and noise.
            rates: Learning rates.
        """
        self._rates = rates
        super().__init__(
            config,
            context_size=context_size,
            max_joint_speed=max_joint_speed,
            control_timestep=control_timestep,
            sigma=_WIDTH.first_sigma,
            seed=seed,
        )

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take in what the action led to, and learn from it."""
        super().observe(timestep)
        step, posture = self._steps[-1], self._last["posture"]
        gate = step["responsibility"][:, None]  # (M, 1)
        next_feedback = self.gains.feedback * self._feedback(self._last)  # (8,)
        self._readouts.forward.nudge(
            step["forward_features"], gate * (posture - step["predictions"]), self._rates.forward
        )
        self._readouts.inverse.nudge(
            step["inverse_features"], gate * next_feedback, self._rates.inverse
        )
        said = self._readouts.predictor(step["predictor_features"])  # (M, 1)
        self._readouts.predictor.nudge(
            step["predictor_features"], gate - said, self._rates.predictor
        )

    def _heard(self, action: Array, module_actions: Array) -> Array:
        return action

    def _learn_epoch(self) -> dict[str, float]:
        """Adapt σ, all else has been learned; log the σ of the episode."""
        sigma = self._sigma
        self._sigma = _WIDTH.next_sigma(self._close_epoch(), sigma)
        return {"sigma": sigma}
