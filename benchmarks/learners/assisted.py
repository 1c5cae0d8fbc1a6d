"""The feedback controller's help for many environments at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import VectorWrapper
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.feedback import feedback_action
from mpma_mj.options import Arms

__all__ = ["Assisted", "make_training"]

Array = NDArray[np.float64]


class Assisted(VectorWrapper[Any, Any, Any]):
    """Adds the feedback controller's action to that of every member, as `FeedbackAssist` does."""

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of every member."""
        self._observation, info = super().reset(**kwargs)
        return self._observation, info

    def step(self, actions: Array) -> tuple[Any, Array, Any, Any, dict[str, Any]]:
        """Act with the feedback controller's help; actions have shape (N, 8)."""
        feedback = feedback_action(
            self._observation["joint_angles"],
            self._observation["reference"],
            self.env.max_joint_speed,
            self.env.control_timestep,
        )
        outcome = super().step(np.clip(actions + feedback, -1.0, 1.0))
        self._observation = outcome[0]
        return outcome


def make_training(num_envs: int, arms: Arms, *, assisted: bool) -> Any:
    """Return environments to train in, with the feedback controller's help or without."""
    env = mpma_mj.make_vec(num_envs, "ymca", arms=arms)
    return Assisted(env) if assisted else env
