"""Learning rules: targets and weights of the readouts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.config import RULE_MEMBERS, RULES
from mpma_mj.agents.extensions import load_class
from mpma_mj.errors import BadOptionError, one_line
from mpma_mj.esn import FeatureReplay, Features, ReadoutBank
from mpma_mj.options import Models

__all__ = [
    "Epoch",
    "GatedRule",
    "LearningRule",
    "Readouts",
    "Step",
    "WeightedRule",
    "desired_command",
    "learning_rule",
]

Array = NDArray[np.float64]


_RECORDED = (
    *("context", "state", "prior", "responsibility", "module_actions", "predictions"),
    *("action", "feedback"),
)


@dataclass(frozen=True, eq=False)
class Readouts:
    """The readouts of all modules.

    Attributes:
        inverse: Of the inverse models.
        forward: Of the forward models.
        predictor: Of the responsibility predictors; None where the gate has none.
    """

    inverse: ReadoutBank
    forward: ReadoutBank
    predictor: ReadoutBank | None = None

    def of_run(self, run: tuple[int, ...]) -> Readouts:
        """Return the readouts of one run of a batch; learning changes these."""
        return Readouts(**{name: bank and bank.of_run(run) for name, bank in vars(self).items()})


@dataclass(frozen=True, eq=False)
class Epoch:
    """The T steps of an epoch of one run of M modules.

    Attributes:
        inverse_features: Reservoir features of the inverse models, shape (T, M, F).
        forward_features: Of the forward models, shape (T, M, F').
        predictor_features: Of the responsibility predictors, shape (T, M, F''); F'' = 0 where
            the gate has none.
        context: Context y, shape (T, C).
        state: Proprioceptive state s, shape (T, S).
        prior: Priors p, shape (T, M).
        responsibility: Responsibilities λ, shape (T, M).
        module_actions: Actions u^i of the inverse models, shape (T, M, 8).
        predictions: Outputs of the forward models, shape (T, M, K): in posture space predicted
            next postures x̂^i, K = 12; in joint space predicted moves, K = 8.
        outcome: What they should have been, shape (T, K): the posture that was reached, or the
            arms' move.
        action: Action u that was taken, shape (T, 8).
        feedback: Feedback action u_fb before its gain, shape (T, 8).
        next_feedback: The same one step later, shape (T, 8).
        feedback_gain: Gain K.
        assignment: Weight of each step for each module, as the gate assigns them, shape (T, M);
            the responsibilities, where it does not.
        desired: Targets of the inverse models' readouts, shape (T, 8): in posture space the desired
            command of feedback-error learning, in joint space residuals known in hindsight.
        usable: Whether inverse models can learn from each step, shape (T,).
    """

    inverse_features: Features | FeatureReplay
    forward_features: Features | FeatureReplay
    predictor_features: Features | FeatureReplay
    context: Array
    state: Array
    prior: Array
    responsibility: Array
    module_actions: Array
    predictions: Array
    outcome: Array
    action: Array
    feedback: Array
    next_feedback: Array
    feedback_gain: float
    assignment: Array
    desired: Array
    usable: NDArray[np.bool_]

    @classmethod
    def without_features(
        cls,
        steps: Mapping[str, Array],
        *,
        outcome: Array,
        next_feedback: Array,
        feedback_gain: float,
    ) -> Epoch:
        """Return an epoch of recorded steps, from which inverse models learn by feedback error.

        Args:
            steps: Steps by name, each of shape (T, ...).
            outcome: What forward models should have predicted, shape (T, K).
            next_feedback: Feedback action one step later, shape (T, 8).
            feedback_gain: Gain K.
        """
        none = np.empty((*steps["prior"].shape, 0))
        return cls(
            **{name: steps[name] for name in _RECORDED},
            inverse_features=none,
            forward_features=none,
            predictor_features=none,
            outcome=outcome,
            next_feedback=next_feedback,
            feedback_gain=feedback_gain,
            assignment=steps["responsibility"],
            desired=desired_command(steps["action"], next_feedback),
            usable=np.ones(len(next_feedback), bool),
        )

    def mixed(self, signal: Array) -> Array:
        """Return the modules' common output, Σ_i λ^i (...)^i, of (T, M, D) shape (T, D)."""
        return np.einsum("tm,tmd->td", self.responsibility, signal)


@dataclass(frozen=True, eq=False)
class Step:
    """One step of all runs with its outcome.

    Attributes:
        inverse_features: Reservoir features of the inverse models, shape (..., M, F).
        forward_features: Of the forward models, shape (..., M, F').
        predictor_features: Of the responsibility predictors, shape (..., M, F''); F'' = 0 where
            the gate has none.
        responsibility: Responsibilities λ, shape (..., M).
        predictions: Outputs of the forward models, shape (..., M, K).
        outcome: What they should have been, shape (..., K).
        next_feedback: Feedback action u_fb for it before its gain, shape (..., 8).
        feedback_gain: Gain K, shape (...).
    """

    inverse_features: Features
    forward_features: Features
    predictor_features: Features
    responsibility: Array
    predictions: Array
    outcome: Array
    next_feedback: Array
    feedback_gain: Array


class LearningRule(ABC):
    """Learning of the readouts, after an epoch (`fit`) or at every step (`partial_fit`).

    Attributes:
        models: Space of the models that the rule is made for, "joint" or "posture".
        forgetting: Forgetting φ of readouts that are fitted, in [0, 1].
        sigma: Width σ of the likelihood of posture models, in units of posture.
        online: Whether `partial_fit` is called at every step, and `fit` never.
        immediate: Whether control passes to the inverse models after the first epoch, instead of
            as their predictions improve.
    """

    models: Models = "posture"
    forgetting: float = 0.0
    sigma: float = 0.25
    online: bool = False
    immediate: bool = False

    @abstractmethod
    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit one run's readouts to an epoch."""

    def partial_fit(self, readouts: Readouts, step: Step) -> None:  # noqa: B027, a hook
        """Change the readouts of all runs by a step."""


@dataclass(frozen=True)
class GatedRule(LearningRule):
    """The paper's process: every error is multiplied by the responsibility.

        forward models           x̂^i + λ^i (x_{t+1} - x̂^i)
        inverse models           u^i + η λ^i (K u_fb)_{t+1}
        responsibility pred.     λ^i

    fitted by ridge regression over the last epoch. The paper leaves open whether training is in
    batches, σ, η and how the gains follow (choices). With these, training ends as the paper's did,
    at a p_e of 3 % after some thirteen epochs; with η = 1 it is 2 % after nine. A larger ρ leaves
    an error that stays: each epoch shrinks the refitted weights.

    Attributes:
        forgetting: φ; 0, so that only the last epoch counts.
        sigma: σ, which is constant; below 0.1 one module wins all, above 0.3 all stay
            active.
        inverse_rate: Learning rate η of the inverse models.
    """

    forgetting: float = 0.0
    sigma: float = 0.25
    inverse_rate: float = 0.2

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit all readouts."""
        gate = epoch.responsibility[:, :, None]
        forward_error = epoch.outcome[:, None, :] - epoch.predictions
        correction = epoch.feedback_gain * epoch.next_feedback[:, None, :]
        inverse_error = self.inverse_rate * correction
        readouts.forward.fit(epoch.forward_features, epoch.predictions + gate * forward_error)
        readouts.inverse.fit(epoch.inverse_features, epoch.module_actions + gate * inverse_error)
        if readouts.predictor is not None:
            readouts.predictor.fit(epoch.predictor_features, gate)


@dataclass(frozen=True)
class WeightedRule(LearningRule):
    """Ours in joint space: least squares of each module on the steps that its gate assigns to it.

        forward models           [q_{t+1} - q_t] / (Δt v)
        inverse models           u_t - u_fb(q_t, x_{t+1})

    The inverse models' examples are exact: the posture that was reached stands in place of the
    target (hindsight relabelling; Andrychowicz et al. 2017). What was learned of a plant stays
    until that plant is on again, and after the first epoch the inverse models control (choices).
    Responsibility predictors and plant models learn in their gate, `PlantGate`.
    """

    models: Models = "joint"
    forgetting: float = 1.0
    immediate: bool = True

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit inverse and forward models."""
        weight = epoch.assignment
        readouts.forward.fit(epoch.forward_features, epoch.outcome[:, None, :], weight)
        usable = weight * epoch.usable[:, None]
        readouts.inverse.fit(epoch.inverse_features, epoch.desired[:, None, :], usable)


def desired_command(action: Array, next_feedback: Array) -> Array:
    """Return the desired command of feedback-error learning, clip(u_t + u_fb,t+1, -1, 1).

    Args:
        action: Action u that was taken, shape (T, 8).
        next_feedback: Feedback action u_fb one step later, shape (T, 8).
    """
    return np.clip(action + next_feedback, -1.0, 1.0)


_BUILT_IN: dict[str, type[LearningRule]] = {"weighted": WeightedRule, "gated": GatedRule}


def learning_rule(rule: str | LearningRule) -> LearningRule:
    """Return a learning rule.

    Args:
        rule: "weighted", "gated", the path of a class, such as my_rules.py:MyRule or
            package.module:MyRule, which is made without arguments; or a rule.

    Raises:
        BadOptionError: There is no such rule, or it cannot be imported or made.
    """
    if not isinstance(rule, str):
        return rule
    if rule in _BUILT_IN:
        return _BUILT_IN[rule]()
    if ":" not in rule:
        raise BadOptionError(option="rule", value=rule, expected=RULES)
    loaded = load_class(rule, "rule", RULE_MEMBERS, base=LearningRule)
    try:
        made: LearningRule = loaded()
    except TypeError as error:
        expected = f"a class that is made without arguments ({one_line(error)})"
        raise BadOptionError(option="rule", value=rule, expected=expected) from None
    return made
