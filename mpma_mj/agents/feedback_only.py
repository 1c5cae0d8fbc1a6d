"""The feedback controller alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Observation
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.fixed import FixedAgent

__all__ = ["FeedbackOnly"]

Array = NDArray[np.float64]


class FeedbackOnly(FixedAgent):
    """The feedback controller without models: u = u_fb, that is K = 1 and L = 0.

    It undoes the error that is there, so that it runs one step behind the demonstration.
    """

    def __init__(self, spec: AgentSpec) -> None:
        """Take what the arms can do.

        Args:
            spec: Where it acts.
        """
        self._spec = spec
        self._steps = EpisodeBuffer()

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self._steps.clear()

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        action = self._spec.feedback(observation["joint_angles"], observation["reference"])
        self._steps.append({"feedback": action})
        return action

    def signals(self) -> dict[str, Array]:
        """Return `feedback`, shape (T, ..., 8), which is the action."""
        return {name: rows.copy() for name, rows in self._steps.episode().items()}
