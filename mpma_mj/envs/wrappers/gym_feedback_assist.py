"""Residual learning through Gymnasium, one environment or many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv, VectorWrapper
from numpy.typing import ArrayLike, NDArray

from mpma_mj.envs.actions import check_action
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.envs.wrappers.gain import check_gain
from mpma_mj.envs.wrappers.unwrapping import unwrap
from mpma_mj.feedback import feedback_action

__all__ = ["GymFeedbackAssist", "VectorFeedbackAssist"]

Array = NDArray[np.float64]


class _FeedbackController:
    """The feedback controller of one environment or of many.

    Attributes:
        gain: Gain K.
    """

    def __init__(self, env: ImitationEnv | VectorImitationEnv, gain: float) -> None:
        self._env = env
        self.gain = check_gain(gain)
        self._feedback: Array = np.zeros(env.action_space.shape)  # type: ignore[arg-type] # a box

    def look(self) -> None:
        """Compute u_fb at once: observations are the agent's, which may write into them."""
        seen, env = self._env.last_observation, self._env
        self._feedback = feedback_action(
            seen["joint_angles"], seen["reference"], env.max_joint_speed, env.control_timestep
        )

    def assist(self, action: ArrayLike) -> tuple[Array, Array]:
        """Return the sum of an action and K u_fb, and K u_fb; the environment clips, and counts."""
        feedback = self.gain * self._feedback
        return check_action(action, feedback.shape) + feedback, feedback


class GymFeedbackAssist(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
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
        self._controller = _FeedbackController(unwrap(env, ImitationEnv), gain)
        RecordConstructorArgs.__init__(self, gain=gain)
        gymnasium.Wrapper.__init__(self, env)

    @property
    def gain(self) -> float:
        """Gain K of the feedback controller, in [0, 1]."""
        return self._controller.gain

    @gain.setter
    def gain(self, gain: float) -> None:
        self._controller.gain = check_gain(gain)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see `ImitationEnv.reset`."""
        outcome = super().reset(seed=seed, options=options)
        self._controller.look()
        return outcome

    def step(self, action: ArrayLike) -> Any:
        """Act with the feedback controller's help; see `ImitationEnv.step`.

        Args:
            action: The agent's action, shape (8,).
        """
        assisted, feedback = self._controller.assist(action)
        *outcome, info = super().step(assisted)
        self._controller.look()
        return *outcome, info | {"feedback": feedback}


class VectorFeedbackAssist(VectorWrapper):
    """`FeedbackAssist` for the environments of `make_vec`, flat or not.

    `info["feedback"]` is the controller's part K u_fb of the step, shape (N, 8); where an episode
    begins, it had no effect.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], gain: float = 1.0) -> None:
        """Wrap environments.

        Args:
            env: Environments that `make_vec` returned, perhaps wrapped.
            gain: Gain K of the feedback controller.

        Raises:
            BadOptionError: The gain is not between 0 and 1, or they are other environments.
        """
        self._controller = _FeedbackController(unwrap(env, VectorImitationEnv), gain)
        super().__init__(env)

    @property
    def gain(self) -> float:
        """Gain K of the feedback controller, in [0, 1]."""
        return self._controller.gain

    @gain.setter
    def gain(self, gain: float) -> None:
        self._controller.gain = check_gain(gain)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of every member; see `VectorImitationEnv.reset`."""
        outcome = super().reset(seed=seed, options=options)  # type: ignore[arg-type] # None too
        self._controller.look()
        return outcome

    def step(self, actions: ArrayLike) -> Any:
        """Act with the feedback controller's help; see `VectorImitationEnv.step`.

        Args:
            actions: The agents' actions, shape (N, 8).
        """
        assisted, feedback = self._controller.assist(actions)
        *outcome, info = super().step(assisted)
        self._controller.look()
        every = np.ones(self.num_envs, bool)
        return *outcome, info | {"feedback": feedback, "_feedback": every}
