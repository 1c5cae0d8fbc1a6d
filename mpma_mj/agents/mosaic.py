"""MOSAIC of Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mpma_mj.agents.base import AgentSpec, Seeds
from mpma_mj.agents.config import AgentConfig, MOSAICConfig
from mpma_mj.agents.gating import ResponsibilityGate
from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts, Step
from mpma_mj.agents.model_space import PostureSpace
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.paired_models import PairedModels

__all__ = ["MOSAIC", "LMSRule"]


@dataclass(frozen=True)
class LMSRule(LearningRule):
    """Normalised LMS at every step, gated by responsibility.

        W_out,i ← W_out,i + η e zᵀ / (ε + zᵀz)

        forward models           e = λ^i (x_{t+1} - x̂^i_{t+1})
        inverse models           e = λ^i (K u_fb)_{t+1}
        responsibility pred.     e = λ^i - RP_i(y)

    The second is feedback-error learning (Kawato 1990): the feedback controller's share of the
    next command is the error of this one.

    Attributes:
        forward_rate: η of the forward models.
        inverse_rate: η of the inverse models.
        predictor_rate: η of the responsibility predictors.
        online: `partial_fit` is called at every step, `fit` never.
    """

    forward_rate: float = 0.2
    inverse_rate: float = 0.2
    predictor_rate: float = 0.1
    online: bool = True

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Do nothing: each step has been learned from."""

    def partial_fit(self, readouts: Readouts, step: Step) -> None:
        """Change the readouts of all runs along their errors in a step."""
        gate = step.responsibility[..., None]  # (..., M, 1)
        forward_error = step.outcome[..., None, :] - step.predictions
        correction = (step.feedback_gain[..., None] * step.next_feedback)[..., None, :]
        readouts.forward.partial_fit(step.forward_features, gate * forward_error, self.forward_rate)
        readouts.inverse.partial_fit(step.inverse_features, gate * correction, self.inverse_rate)
        if readouts.predictor is not None:
            error = gate - readouts.predictor(step.predictor_features)
            readouts.predictor.partial_fit(step.predictor_features, error, self.predictor_rate)


class MOSAIC(PairedModels):
    """Modules of forward and inverse model that learn at every step, gated by responsibility.

    `PairedModels` with a `ResponsibilityGate` and the `LMSRule`. The command, the responsibilities
    and the schedule of the gains are MPMA's, so that both are compared on equal terms (choice).
    Every forward model receives the total command. As it learns within an episode, a trainer has
    to keep the state of the episode's beginning.

    σ is constant (choice). At 0.5, where MPMA's weighted rule begins, the likelihood is nearly
    flat and the context decides; at 0.144 one module wins everything; and if σ follows the
    prediction error, as under that rule, modules divide inside labels, which predictors cannot
    tell by context.
    """

    config_type: ClassVar[type[AgentConfig]] = MOSAICConfig

    def __init__(self, config: MOSAICConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs; arguments as of `Agent`."""
        networks = NetworkFactory(config, seed, config.modules)
        gate = ResponsibilityGate(networks, spec.context_size, sigma=config.sigma)
        rule = LMSRule(config.forward_rate, config.inverse_rate, config.predictor_rate)
        space = PostureSpace(spec, proprioception=config.proprioception)
        super().__init__(config, spec, networks=networks, gate=gate, rule=rule, space=space)
