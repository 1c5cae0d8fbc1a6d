"""The feedback controller alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent import Observation
from mpma_mj.agents.fixed import FixedAgent
from mpma_mj.feedback import feedback_action

__all__ = ["FeedbackOnly"]

Array = NDArray[np.float64]


class FeedbackOnly(FixedAgent):
    """The feedback controller without models: u = u_fb, that is K = 1 and L = 0.

    It undoes the error that is there, so that it runs one step behind the demonstration.
    """

    def __init__(self, *, max_joint_speed: Array, control_timestep: float) -> None:
        """Take what the arms can do.

        Args:
            max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
            control_timestep: Time between two actions, s.
        """
        self._max_joint_speed = max_joint_speed
        self._control_timestep = control_timestep
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self._feedback: list[Array] = []

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (8,), in [-1, 1]."""
        action = feedback_action(
            observation["joint_angles"],
            observation["reference"],
            self._max_joint_speed,
            self._control_timestep,
        )
        self._feedback.append(action.copy())
        return action

    def signals(self) -> dict[str, Array]:
        """Return `feedback`, shape (T, 8), which is the action."""
        return {"feedback": np.reshape(self._feedback, (-1, 8))}
