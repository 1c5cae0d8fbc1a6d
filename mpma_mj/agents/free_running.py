"""Free-running: trained agents that imitate without the demonstration."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.anticipation import Anticipation
from mpma_mj.agents.base import Agent, Observation
from mpma_mj.agents.config import POSTURE
from mpma_mj.agents.wrappers import Frozen, paired_models_of
from mpma_mj.errors import BadOptionError

__all__ = ["ClosedLoop", "DemonstrationSource", "FreeRunning", "OwnPrediction"]

Array = NDArray[np.float64]


class DemonstrationSource(Protocol):
    """Postures that stand in for the demonstration."""

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def __call__(self, observation: Observation, shown: bool) -> Observation:
        """Return the observation with its reference and target.

        Args:
            observation: The observation.
            shown: Whether the demonstration is on; then the observation is returned as it is.
        """


class OwnPrediction:
    """The posture that an agent's own forward models predicted at the step before.

    x'_t = x'_{t+1} = Σ_i λ^i x̂^i
    """

    def __init__(self, agent: Agent) -> None:
        """Use the forward models of an agent.

        Raises:
            BadOptionError: The agent has no forward models, or compensates a latency.
        """
        self._pairs = paired_models_of(agent)
        if self._pairs.senses.late:
            expected = "an agent without latency, as predictions are of the next step"
            raise BadOptionError(option="latency", value=agent.spec.latency, expected=expected)

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def __call__(self, observation: Observation, shown: bool) -> Observation:
        """Return the observation with the prediction as reference and target."""
        if shown:
            return observation
        predicted = self._pairs.predicted_posture()
        return dict(observation) | {"target": predicted, "reference": predicted}


class ClosedLoop:
    """A reservoir that anticipates the demonstration from what it anticipated itself.

    x'_{t+1} = anticipation(x'_t, x'_{t-1}, clock_{t-1})
    """

    def __init__(self, anticipation: Anticipation, clock: Array) -> None:
        """Close the loop.

        Args:
            anticipation: A reservoir that has learned the demonstration.
            clock: Its context in a repetition of the motion, shape (P, C).
        """
        self._anticipation, self._clock = anticipation, clock

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self._anticipation.reset(episode)
        self._step = 0
        self._target = self._following = np.zeros(POSTURE)

    def __call__(self, observation: Observation, shown: bool) -> Observation:
        """Return the observation with what is anticipated as reference and target."""
        if not shown:
            coming = {"reference": self._target, "target": self._following}
            observation = dict(observation) | coming
        context = {"context": self._clock[self._step % len(self._clock)]}
        self._step += 1
        self._target = observation["target"]
        self._following = self._anticipation(dict(observation) | context)[..., 1, :]
        return observation


class FreeRunning(Frozen):
    """An agent that after a warm-up receives other postures than the demonstration.

    They are the inverse models' target and the feedback controller's reference. The context stays.
    """

    def __init__(self, agent: Agent, source: DemonstrationSource, warmup_steps: int) -> None:
        """Wrap an agent.

        Args:
            agent: A trained agent.
            source: What it receives after the warm-up.
            warmup_steps: Steps of an episode with the demonstration, at least 1.
        """
        super().__init__(agent)
        self._source, self._warmup_steps = source, warmup_steps
        self._step = 0

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self._source.reset(episode)
        self._step = 0

    def act(self, observation: Observation) -> Array:
        """Return the action for the demonstration, or after the warm-up for what replaces it."""
        shown = self._step < self._warmup_steps
        self._step += 1
        return super().act(self._source(observation, shown))
