"""Agents from which the demonstration is taken away."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent import Agent, Observation
from mpma_mj.agents.frozen import Frozen
from mpma_mj.agents.wrapper import pairs_of

__all__ = ["Freed"]

Array = NDArray[np.float64]


class Freed(Frozen):
    """An agent that after a lead-in goes by its own prediction, and hears only the music.

        x'_t = x'_{t+1} = Σ_i λ^i x̂^i        of the step before

    So both the inverse models' target and the feedback controller's reference are what its
    forward models expect the posture to be now. It learns nothing more.
    """

    def __init__(self, agent: Agent, lead_in: int) -> None:
        """Stand between.

        Args:
            agent: A trained agent.
            lead_in: Steps of an episode with the demonstration, at least 1.

        Raises:
            BadOptionError: The agent has no forward models.
        """
        super().__init__(agent)
        self._pairs = pairs_of(agent)
        self._lead_in = lead_in
        self._step = 0

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self._step = 0

    def act(self, observation: Observation) -> Array:
        """Return the action for the demonstration, or after the lead-in for the prediction."""
        if self._step >= self._lead_in:
            expected = self._pairs.expected()
            observation = dict(observation) | {"target": expected, "reference": expected}
        self._step += 1
        return super().act(observation)
