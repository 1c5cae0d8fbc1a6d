"""Residual learning through Gymnasium, one environment or many."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import VectorWrapper
from numpy.typing import ArrayLike, NDArray

from mpma_mj.envs.actions import check_action, clip_action
from mpma_mj.envs.gym import ImitationEnv
from mpma_mj.envs.vector import VectorImitationEnv
from mpma_mj.envs.wrappers.gain import check_gain
from mpma_mj.errors import BadOptionError
from mpma_mj.feedback import feedback_action

__all__ = ["GymFeedbackAssist", "VectorFeedbackAssist"]

Array = NDArray[np.float64]


class _Controller:
    """The feedback controller of one environment or of many.

    Attributes:
        feedback: K u_fb of what was seen last, shape (8,) or (N, 8).
    """

    def __init__(self, env: Any, gain: float) -> None:
        inner = env.unwrapped
        if not isinstance(inner, ImitationEnv | VectorImitationEnv):
            raise BadOptionError(f"env is {inner}; expected one of TwoArmImitation, or of make_vec")
        self._env = inner
        self._gain = check_gain(gain)
        self.feedback: Array = np.zeros(env.action_space.shape)

    def look(self) -> None:
        """Compute the feedback at once: observations are the agent's, which may write into them."""
        seen, env = self._env.seen, self._env
        self.feedback = self._gain * feedback_action(
            seen["joint_angles"], seen["reference"], env.max_joint_speed, env.control_timestep
        )

    def assist(self, action: ArrayLike) -> Array:
        """Return the sum of an action and the feedback, clipped."""
        return clip_action(check_action(action, self.feedback.shape) + self.feedback)


class GymFeedbackAssist(gymnasium.Wrapper[Any, Any, Any, Any]):
    """`FeedbackAssist` for an environment of `gymnasium.make`, flat or not.

    `info["feedback"]` is the controller's part K u_fb of the step, shape (8,).
    """

    def __init__(self, env: gymnasium.Env[Any, Any], gain: float = 1.0) -> None:
        """Wrap an environment.

        Args:
            env: Environment that `gymnasium.make` returned, perhaps wrapped.
            gain: Gain K of the feedback controller.

        Raises:
            BadOptionError: The gain is not between 0 and 1, or it is another environment.
        """
        super().__init__(env)
        self._controller = _Controller(env, gain)

    def reset(self, **options: Any) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see `ImitationEnv.reset`."""
        outcome = super().reset(**options)
        self._controller.look()
        return outcome

    def step(self, action: ArrayLike) -> Any:
        """Act with the feedback controller's help; see `ImitationEnv.step`.

        Args:
            action: The agent's action, shape (8,).
        """
        feedback = self._controller.feedback
        *outcome, info = super().step(self._controller.assist(action))
        self._controller.look()
        return *outcome, info | {"feedback": feedback}


class VectorFeedbackAssist(VectorWrapper[Any, Any, Any]):
    """`FeedbackAssist` for the environments of `make_vec`, flat or not.

    `info["feedback"]` is the controller's part K u_fb of the step, shape (N, 8); where an episode
    begins, it had no effect.
    """

    def __init__(self, env: VectorImitationEnv, gain: float = 1.0) -> None:
        """Wrap environments; arguments and errors are those of `GymFeedbackAssist`."""
        super().__init__(env)
        self._controller = _Controller(env, gain)

    def reset(self, **options: Any) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of every member; see `VectorImitationEnv.reset`."""
        outcome = super().reset(**options)
        self._controller.look()
        return outcome

    def step(self, actions: ArrayLike) -> Any:
        """Act with the feedback controller's help; see `VectorImitationEnv.step`.

        Args:
            actions: The agents' actions, shape (N, 8).
        """
        feedback = self._controller.feedback
        *outcome, info = super().step(self._controller.assist(actions))
        self._controller.look()
        every = np.ones(self.num_envs, bool)
        return *outcome, info | {"feedback": feedback, "_feedback": every}
