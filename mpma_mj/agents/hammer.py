"""HAMMER of Demiris & Khadhouri 2006: prepared pairs that compete for control."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation, Seeds
from mpma_mj.agents.config import AgentConfig, HAMMERConfig
from mpma_mj.agents.gating import Gate, prediction_errors
from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts
from mpma_mj.agents.model_space import model_space
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.context import active_label
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.saved_arrays import shared_count

__all__ = ["HAMMER", "ConfidenceGate", "PreparationRule", "next_confidence"]

Array = NDArray[np.float64]

# Choices: Demiris & Khadhouri leave the preparation to the experiment, and do not bound
# confidence; here a pair that was right for long can be overtaken within a quarter second.
_PREPARATION = 3  # epochs
_MOST = 5.0  # confidence, steps


def next_confidence(confidence: Array, errors: Array) -> Array:
    """Return the confidences after a step: one more where a prediction was right, else one less.

        c^i ← clip(c^i ± 1, 0, 5)        right is the pair with the least error

    In Demiris & Khadhouri 2006 a threshold decides which errors are right, set by the
    experimenter; the least error needs none (choice).

    Args:
        confidence: Confidences c, shape (..., M).
        errors: Errors of the last predictions, shape (..., M).
    """
    change = np.where(errors == errors.min(axis=-1, keepdims=True), 1.0, -1.0)
    return clip(confidence + change, 0.0, _MOST)


class ConfidenceGate(Gate):
    """The most confident pair has all control.

        c^i ← c^i ± 1         λ = one-hot(argmax_i c^i)

    A pair is right if its forward model predicts the demonstrator's next posture: x̂^i against x',
    in either space of the models. During preparation the pair of the present label has control,
    without a label the first (choice).

    Attributes:
        prepared: Epochs of preparation so far.
    """

    def __init__(self, networks: NetworkFactory) -> None:
        """Begin without confidence in any pair; there is one for each of the networks' modules."""
        self.prepared = 0
        self.enabled = np.ones(networks.modules, bool)
        self._context_size = networks.modules
        self._batch_shape = np.shape(networks.seed)
        self._confidence = np.zeros((*self._batch_shape, networks.modules))

    @property
    def is_preparing(self) -> bool:
        """Whether pairs still learn, each its own label."""
        return self.prepared < _PREPARATION

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return λ of a step, one-hot, shape (..., M), as prior and as responsibility."""
        context = observation["context"]
        if context.shape[-1] != self._context_size:
            raise BadOptionError(
                option="context",
                value=context.shape,
                expected=f"{self._context_size} labels, one for each pair of HAMMER",
            )
        if predictions is not None:
            errors = prediction_errors(predictions, observation["reference"])
            self._confidence = next_confidence(self._confidence, errors)
        best = np.where(self.enabled, context if self.is_preparing else self._confidence, -1.0)
        one_hot = np.eye(self._context_size)[np.argmax(best, axis=-1)] * self.enabled
        return one_hot, one_hot

    def reset(self, episode: int) -> None:
        """Begin an episode without confidence in any pair."""
        self._confidence = np.zeros((*self._batch_shape, self._context_size))

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._batch_shape = runs.shape

    def state_dict(self) -> dict[str, Array]:
        """Return the number of epochs of preparation, for each run."""
        return {"prepared": np.full(self._batch_shape, self.prepared)}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self.prepared = shared_count(state["prepared"], self._batch_shape)


class PreparationRule(LearningRule):
    """Ridge regression of each pair on the steps of its own label, while it is prepared (choice).

        posture models   forward x_{t+1}                   inverse clip(u_t + u_fb,t+1, -1, 1)
        joint models     forward [q_{t+1} - q_t] / (Δt v)  inverse u_t - u_fb(q_t, x_{t+1})

    From steps without a label no pair learns.
    """

    forgetting = 1.0  # all epochs of preparation count alike

    def __init__(self, gate: ConfidenceGate) -> None:
        """Follow the preparation of a gate."""
        self._gate = gate

    def fit(self, readouts: Readouts, epoch: Epoch) -> None:
        """Refit one run's readouts, if the preparation is not over."""
        if not self._gate.is_preparing:
            return
        own = active_label(epoch.context)[:, None] == np.arange(epoch.context.shape[1])
        weight = (own & self._gate.enabled).astype(float)  # (T, M)
        usable = weight * epoch.usable[:, None]
        readouts.forward.fit(epoch.forward_features, epoch.outcome[:, None, :], weight)
        readouts.inverse.fit(epoch.inverse_features, epoch.desired[:, None, :], usable)


class HAMMER(PairedModels):
    """A pair of inverse and forward model for each label of the context; the best takes all.

    `PairedModels` with a `ConfidenceGate` and the `PreparationRule`. Nothing is mixed, there is
    no responsibility predictor, and after the preparation the context is not used.

    Preparation (choice): in the first 3 epochs the feedback controller leads, K and L are
    constant, and forward models receive the total command. Then learning is over, forward models
    receive their own inverse model's command, and K and L change as those of MPMA with the paper's
    rule do.
    """

    config_type: ClassVar[type[AgentConfig]] = HAMMERConfig
    fine_tunable: bool = False
    _gate: ConfidenceGate

    def __init__(self, config: HAMMERConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs; arguments as of `Agent`."""
        forgetting = PreparationRule.forgetting
        networks = NetworkFactory.fitted(config, seed, spec.context_size, forgetting)
        gate = ConfidenceGate(networks)
        space = model_space(config, spec)
        rule = PreparationRule(gate)
        super().__init__(config, spec, networks=networks, gate=gate, rule=rule, space=space)

    @property
    def is_preparing(self) -> bool:
        """Whether pairs still learn, each its own label."""
        return self._gate.is_preparing

    def learn(self) -> dict[str, Array]:
        """Learn from the episode during preparation; afterwards let the gains follow."""
        if not self.is_preparing:
            return super().learn()
        progress = self._progress.copy()
        logged = super().learn()
        self._progress = progress
        self._gate.prepared += 1
        self._choose_efference_copy()
        return logged

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; see `PairedModels`."""
        super().load_state_dict(state)
        self._choose_efference_copy()

    def _choose_efference_copy(self) -> None:
        self._efference_copy = "total" if self.is_preparing else "module"
