"""The two learning rules: what every readout of a module should have said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.gating import prediction_errors, predictor_target
from mpma_mj.esn import FeatureReplay, Features, ReadoutBank
from mpma_mj.options import RuleName

__all__ = [
    "RULES",
    "Epoch",
    "GatedRule",
    "LearningRule",
    "PairReadouts",
    "Readouts",
    "WeightedRule",
    "desired_command",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PairReadouts:
    """The readouts of all pairs of inverse and forward model."""

    inverse: ReadoutBank
    forward: ReadoutBank

    def state_dict(self) -> dict[str, Array]:
        """Return a copy of all that they have learned, as arrays by name."""
        return {
            f"{part}.{name}": value
            for part, bank in vars(self).items()
            for name, value in bank.state_dict().items()
        }

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned, of which more is passed over.

        Raises:
            KeyError: Something is missing.
        """
        for part, bank in vars(self).items():
            bank.load_state_dict(state, f"{part}.")


@dataclass(frozen=True, eq=False)
class Readouts(PairReadouts):
    """The three readouts of all modules."""

    predictor: ReadoutBank

    def of_run(self, index: tuple[int, ...]) -> Readouts:
        """Return one run's, of agents side by side."""
        return Readouts(**{name: bank.of_run(index) for name, bank in vars(self).items()})

    def first_modules(self, count: int) -> Readouts:
        """Return those of the first modules."""
        return Readouts(**{name: bank.first_modules(count) for name, bank in vars(self).items()})

    def take(self, other: Readouts) -> None:
        """Become a copy of readouts of the same shapes."""
        self.load_state_dict(other.state_dict())


@dataclass(frozen=True, eq=False)
class Epoch:
    """What happened to M modules in the T steps of an epoch.

    Attributes:
        inverse_features: Reservoir features of the inverse models, shape (T, M, F).
        forward_features: Of the forward models, shape (T, M, F').
        predictor_features: Of the responsibility predictors, shape (T, M, F'').
        prior: Outputs p of the responsibility predictors, shape (T, M).
        responsibility: Responsibilities λ, shape (T, M).
        module_actions: Actions u^i of the inverse models, shape (T, M, 8).
        predictions: Predicted next postures x̂^i, shape (T, M, 12).
        action: Action u that was taken, shape (T, 8).
        next_posture: Posture that came of it, shape (T, 12).
        feedback: Feedback action u_fb before its gain, shape (T, 8).
        next_feedback: The same one step later, shape (T, 8).
        feedback_gain: K.
    """

    inverse_features: Features | FeatureReplay
    forward_features: Features | FeatureReplay
    predictor_features: Features | FeatureReplay
    prior: Array
    responsibility: Array
    module_actions: Array
    predictions: Array
    action: Array
    next_posture: Array
    feedback: Array
    next_feedback: Array
    feedback_gain: float

    @classmethod
    def of(cls, episode: Mapping[str, Any]) -> Epoch:
        """Return it from what was remembered, by name, of which more is passed over."""
        known = {f.name: episode[f.name] for f in fields(cls) if f.name != "feedback_gain"}
        return cls(**known, feedback_gain=float(episode["feedback_gain"][0]))


class LearningRule(Protocol):
    """A way to refit the readouts after an epoch."""

    @property
    def forgetting(self) -> float:
        """Forgetting φ of the readouts."""

    @property
    def first_sigma(self) -> float:
        """Width σ of the likelihood in the first epoch."""

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit all readouts."""

    def next_sigma(self, epoch: Epoch, sigma: float) -> float:
        """Return the width σ of the likelihood for the next epoch."""


@dataclass(frozen=True)
class GatedRule:
    """The paper's process: every error is multiplied by the responsibility.

        forward models           x̂^i + λ^i (x_{t+1} - x̂^i)
        inverse models           u^i + η λ^i (K u_fb)_{t+1}
        responsibility pred.     λ^i

    fitted by ridge regression over the last epoch. The paper says neither whether training is
    in batches nor σ, η or how the gains follow (choices). With these training ends as the paper's
    did, when p_e has come down to 3 % after some thirteen epochs; with η = 1 it is at 2 % after
    nine. A larger ρ leaves an error that never goes away: each epoch shrinks what is refitted.

    Attributes:
        forgetting: φ; 0, so that only the last epoch counts.
        first_sigma: σ, which stays; under 0.1 one module wins all, above 0.3 all stay active.
        inverse_rate: Learning rate η of the inverse models.
    """

    forgetting: float = 0.0
    first_sigma: float = 0.25
    inverse_rate: float = 0.2

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit all readouts."""
        gate = epoch.responsibility[:, :, None]
        forward_error = epoch.next_posture[:, None, :] - epoch.predictions
        correction = epoch.feedback_gain * epoch.next_feedback[:, None, :]
        inverse_error = self.inverse_rate * correction
        readouts.forward.fit(epoch.forward_features, epoch.predictions + gate * forward_error)
        readouts.inverse.fit(epoch.inverse_features, epoch.module_actions + gate * inverse_error)
        readouts.predictor.fit(epoch.predictor_features, gate)

    def next_sigma(self, epoch: Epoch, sigma: float) -> float:
        """Return σ unchanged."""
        return sigma


@dataclass(frozen=True)
class WeightedRule:
    """Ours: least squares weighted by responsibility, remembering earlier epochs (choice).

    It is the fixed point of gated gradient steps, reached at once:

        forward models           x_{t+1}                              weight λ^i
        inverse models           clip(u_t + u_fb,t+1, -1, 1)          weight λ^i
        responsibility pred.     y ∝ (λ^i)^γ c_i, all used alike      weight 1

    where the inverse models' target is the command that would have hit. After each epoch σ is
    the responsible modules' rms prediction error, but not under `least_sigma`.

    Attributes:
        forgetting: φ.
        first_sigma: σ of the first epoch, in which predictions say nothing yet.
        least_sigma: Least σ. With 0.02, the size of the demonstration's noise, modules that share a
            label take turns by chance, which no predictor can know.
        sharpening: γ.
    """

    forgetting: float = 0.7
    first_sigma: float = 0.5
    least_sigma: float = 0.04
    sharpening: float = 3.0

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit all readouts."""
        weight = epoch.responsibility
        hit = desired_command(epoch.action, epoch.next_feedback)
        share = predictor_target(weight, self.sharpening)
        readouts.forward.fit(epoch.forward_features, epoch.next_posture[:, None, :], weight)
        readouts.inverse.fit(epoch.inverse_features, hit[:, None, :], weight)
        readouts.predictor.fit(epoch.predictor_features, share[:, :, None])

    def next_sigma(self, epoch: Epoch, sigma: float) -> float:
        """Return the rms prediction error, weighted by responsibility."""
        errors = prediction_errors(epoch.predictions, epoch.next_posture)
        rms = np.sqrt(np.mean(np.sum(epoch.responsibility * errors, axis=1)))
        return max(self.least_sigma, float(rms))


def desired_command(action: Array, next_feedback: Array) -> Array:
    """Return what inverse models should have said, clip(u_t + u_fb,t+1, -1, 1).

    Args:
        action: Action u that was taken, shape (T, 8).
        next_feedback: Feedback action u_fb one step later, shape (T, 8).
    """
    return np.clip(action + next_feedback, -1.0, 1.0)


RULES: dict[RuleName, LearningRule] = {"weighted": WeightedRule(), "gated": GatedRule()}
