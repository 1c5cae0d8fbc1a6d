"""MOSAIC of Wolpert & Kawato 1998 and Haruno, Wolpert & Kawato 2001."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mpma_mj.agents.base import AgentSpec, Seeds
from mpma_mj.agents.config import AgentConfig, MOSAICConfig
from mpma_mj.agents.gating import ResponsibilityGate
from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts, Step
from mpma_mj.agents.model_space import model_space
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.paired_models import PairedModels

__all__ = ["MOSAIC", "LMSRule"]

_INVERSE_RATES = {"joint": 0.02, "posture": 0.2}  # by the models' space (choice)


@dataclass(frozen=True)
class LMSRule(LearningRule):
    """Normalised LMS at every step, gated by responsibility.

        W_out,i ← W_out,i + η e zᵀ / (ε + zᵀz)

        forward models           e = λ^i (x_{t+1} - x̂^i_{t+1}), of joint models of moves
        inverse models           e = λ^i (K u_fb)_{t+1}
        responsibility pred.     e = λ^i - RP_i(y)

    The second is feedback-error learning (Kawato 1990) in both spaces: the feedback controller's
    share of the next command is the error of this one.

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
    and the schedule of the gains are those of MPMA with the paper's rule, so that both are compared
    on equal terms (choice). Likelihoods compare predicted postures in either space of the models.
    Every forward model receives the total command. As it learns within an episode, a trainer has to
    keep the state of the episode's beginning.

    σ is constant (choice). At 0.5 the likelihood is nearly flat and the context decides. At 0.144
    one module wins everything with posture models; with joint models modules divide labels better,
    but p_e rises from 0.63 to 0.93 %. If σ follows the prediction error, posture models divide
    inside labels, which predictors cannot distinguish by context.

    Rates of joint models (choice): of 0.02, 0.05, 0.1 and 0.2 for forward and inverse models each,
    on YMCA with five seeds, 0.02 of the inverse models, the lowest, has the least p_e: 0.63 % when
    control has passed and 0.51 % after 15 epochs, instead of 1.9 and 1.0 % at 0.2. While L is
    small, the feedback controller's share contains what the resolved-rate command is about to do,
    and the residual learns it once more. The forward models' rate makes hardly any difference.
    """

    config_type: ClassVar[type[AgentConfig]] = MOSAICConfig

    def __init__(self, config: MOSAICConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs; arguments as of `Agent`."""
        networks = NetworkFactory(config, seed, config.modules)
        gate = ResponsibilityGate(networks, spec.context_size, sigma=config.sigma)
        inverse_rate = config.inverse_rate or _INVERSE_RATES[config.models]
        rule = LMSRule(config.forward_rate, inverse_rate, config.predictor_rate)
        space = model_space(config, spec)
        super().__init__(config, spec, networks=networks, gate=gate, rule=rule, space=space)
