"""HAMMER of Demiris & Khadhouri 2006: pairs that are prepared, and compete for control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Observation, Seeds
from mpma_mj.agents.config import NetworkConfig
from mpma_mj.agents.gating import prediction_errors
from mpma_mj.agents.learning_rules import desired_command
from mpma_mj.agents.paired_models import PairedModels, RunIndex
from mpma_mj.context import active_label
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.clipping import clip

__all__ = ["HAMMER", "next_confidence"]

Array = NDArray[np.float64]

# Choices: Demiris & Khadhouri leave the preparation to the experiment, and let confidence grow
# without bound; here a pair that was right for long has to be overtaken within a quarter second.
_PREPARATION = 3  # epochs
_MOST = 5.0  # confidence, steps


def next_confidence(confidence: Array, errors: Array) -> Array:
    """Return what confidences become: one more where a prediction was right, else one less.

        c^i ← clip(c^i ± 1, 0, 5)        right is the pair with the least error

    Which errors count as right is the experimenter's threshold in Demiris & Khadhouri 2006; to
    be the best predictor of the step needs none (choice).

    Args:
        confidence: Confidences c, shape (..., M).
        errors: Errors of the last predictions, shape (..., M).
    """
    change = np.where(errors == errors.min(axis=-1, keepdims=True), 1.0, -1.0)
    return clip(confidence + change, 0.0, _MOST)


class HAMMER(PairedModels):
    """A pair of inverse and forward model per context label; the most confident takes all.

        x̂^i = FM_i([u^i ; x ; s])         c^i ← c^i ± 1         λ = one-hot(argmax_i c^i)

    A pair is right if its forward model says of its own inverse model's command what the
    demonstrator then does: x̂^i against x'. So confidence recognises the movement, and the context
    is not heard. Nothing is mixed; there is no responsibility predictor.

    Preparation (choice): in the first 3 epochs the feedback controller leads, K and L wait, each
    pair has control in the steps of its own label and learns from these only, by ridge
    regression: the forward model x_{t+1} of the command that was taken, the inverse model
    clip(u_t + u_fb,t+1, -1, 1), the command that would have hit. In steps without a label the first
    pair has control (choice), and none learns. Then learning is over, and K and L move on as
    MPMA's do.
    """

    def __init__(self, config: NetworkConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Draw the reservoirs.

        Args:
            config: Settings of the networks; `modules` is the number of context labels.
            spec: Where it acts.
            seed: Seed of weights and noise; several are agents side by side.
        """
        self._prepared = 0  # epochs
        self._labels = np.arange(config.modules)  # each pair's
        self._known = config.modules  # labels for which there was a pair
        super().__init__(
            config,
            spec,
            seed=seed,
            forgetting=1.0,  # every epoch of preparation counts alike
        )

    @property
    def is_preparing(self) -> bool:
        """Whether pairs still learn, each its own label."""
        return self._prepared < _PREPARATION

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and no confidence in any pair."""
        super().reset(episode)
        self._confidence = np.zeros((*self._batch_shape, self._modules))

    def learn_batch(self) -> list[dict[str, float]]:
        """Learn from the episode while preparing; afterwards let the gains follow."""
        if not self.is_preparing:
            return super().learn_batch()
        progress = self._progress.copy()
        logged = super().learn_batch()
        self._progress = progress
        self._prepared += 1
        return logged

    def drop_modules(self, modules: Sequence[int]) -> None:
        """Go on without some of the pairs, which win no more; the others keep their labels.

        Args:
            modules: Their numbers, from 0, shape (K,).

        Raises:
            BadOptionError: There are no others.
        """
        super().drop_modules(modules)
        self._labels = np.delete(self._labels, modules)

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""
        return super().state_dict() | {"prepared": np.full(self._batch_shape, self._prepared)}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        super().load_state_dict(state)
        self._prepared = int(np.max(state["prepared"]))

    def _gate(self, observation: Observation) -> dict[str, Array]:
        context = observation["context"]
        if context.shape[-1] != self._known:
            raise BadOptionError(
                f"modules is {self._known}, but the context has {context.shape[-1]} labels;"
                " HAMMER has a pair for each"
            )
        if len(self._steps):
            predictions = self._steps.last("predictions")
            errors = prediction_errors(predictions, observation["reference"])
            self._confidence = next_confidence(self._confidence, errors)
        prepared = context[..., self._labels]
        winner = np.argmax(prepared if self.is_preparing else self._confidence, axis=-1)
        one_hot = np.eye(self._modules)[winner]
        return {"prior": one_hot, "responsibility": one_hot, "context": context}

    def _efference_copy(self, action: Array, module_actions: Array) -> Array:
        return action if self.is_preparing else module_actions

    def _learn_epoch(self, run: RunIndex, episode: dict[str, Array]) -> dict[str, float]:
        """Fit each pair to the steps of its label, if the preparation is not over."""
        if self.is_preparing:
            own = active_label(episode["context"])[:, None] == self._labels
            weight = own.astype(float)  # (T, M)
            hit = desired_command(episode["action"], episode["next_feedback"])
            self._readouts.forward.of_run(run).fit(
                episode["forward_features"], episode["next_posture"][:, None, :], weight
            )
            self._readouts.inverse.of_run(run).fit(
                episode["inverse_features"], hit[:, None, :], weight
            )
        return {}
