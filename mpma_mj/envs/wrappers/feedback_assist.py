"""Residual learning: the agent acts on top of the feedback controller."""

from __future__ import annotations

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.actions import check_action
from mpma_mj.envs.wrappers.base import Wrapper
from mpma_mj.envs.wrappers.gain import check_gain
from mpma_mj.feedback import feedback_action
from mpma_mj.utils.clipping import clip

__all__ = ["FeedbackAssist"]

Array = NDArray[np.float64]


class FeedbackAssist(Wrapper):
    """Adds the feedback controller's action to that of any agent.

        u = clip(u_agent + K u_fb, -1, 1)

    With K = 1 an agent that does nothing is already led along the demonstration, and learns only
    what is missing. `gain` may be changed at any time, such as from episode to episode.

    Attributes:
        last_action: Action u of the last step, shape (8,).
        last_feedback: K u_fb of the last step, shape (8,).
    """

    def __init__(self, env: dm_env.Environment, gain: float = 1.0) -> None:
        """Wrap an environment.

        Args:
            env: Environment that `mpma_mj.load` returned, perhaps wrapped.
            gain: Gain K of the feedback controller.

        Raises:
            BadOptionError: The gain is not between 0 and 1.
        """
        super().__init__(env)
        self.gain = gain
        self.last_action = self.last_feedback = np.zeros(8)
        self._feedback = np.zeros(8)

    @property
    def gain(self) -> float:
        """Gain K of the feedback controller, in [0, 1]."""
        return self._gain

    @gain.setter
    def gain(self, gain: float) -> None:
        self._gain = check_gain(gain)

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act with the feedback controller's help.

        Args:
            action: The agent's action, shape (8,).
        """
        feedback = self.gain * self._feedback
        assisted = check_action(action) + feedback  # the environment clips, and counts
        timestep = super().step(assisted)
        if not timestep.first():
            self.last_action, self.last_feedback = clip(assisted), feedback
        return timestep

    def _begun(self, timestep: dm_env.TimeStep) -> None:
        self._feedback = self._controller(timestep)

    def _stepped(self, action: Array, timestep: dm_env.TimeStep) -> None:
        self._feedback = self._controller(timestep)

    def _controller(self, timestep: dm_env.TimeStep) -> Array:
        """Return u_fb at once: observations are the agent's, which may write into them."""
        return feedback_action(
            timestep.observation["joint_angles"],
            timestep.observation["reference"],
            self._env.task.max_joint_speed,
            self._env.control_timestep(),
        )
