"""Residual learning: the agent acts on top of the feedback controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import dm_env
import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv, VectorWrapper
from numpy.typing import ArrayLike, NDArray

from mpma_mj.arm_kinematics import ArmKinematics
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.option_checks import is_within
from mpma_mj.envs.step_rules import check_action
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.envs.wrappers.base import Wrapper, unwrap
from mpma_mj.errors import BadOptionError
from mpma_mj.feedback import feedback_action, followed
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.validation import Bounds

__all__: list[str] = ["FeedbackAssist", "GymFeedbackAssist", "VectorFeedbackAssist", "checked_gain"]

Array = NDArray[np.float64]

_GAIN = Bounds(0.0, 1.0)


class _Controller:
    """The feedback controller of one environment or of many.

    Attributes:
        gain: Gain K.
    """

    def __init__(
        self,
        gain: float,
        max_joint_speed: Array,
        control_timestep: float,
        kinematics: ArmKinematics,
        *batch: int,
    ) -> None:
        """Begin without an error.

        Args:
            gain: Gain K.
            max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
            control_timestep: Time between two actions, s.
            kinematics: Kinematics of the arms.
            *batch: Leading shape of actions.
        """
        self.gain = checked_gain("gain", gain)
        self._limits = max_joint_speed, control_timestep, kinematics
        self._feedback = np.zeros((*batch, 8))

    def observe(self, observation: Mapping[str, Array]) -> None:
        """Compute u_fb at once, since the agent may write into the observation later."""
        self._feedback = feedback_action(
            observation["joint_angles"], followed(observation, "reference"), *self._limits
        )

    def assist(self, action: ArrayLike) -> tuple[Array, Array]:
        """Return u_agent + K u_fb, which the environment clips, and K u_fb, shape (..., 8)."""
        feedback = self.gain * self._feedback
        return check_action(action, feedback.shape) + feedback, feedback


class _Assisted:
    """The gain of wrappers that assist."""

    _controller: _Controller

    @property
    def gain(self) -> float:
        """Gain K of the feedback controller, in [0, 1]."""
        return self._controller.gain

    @gain.setter
    def gain(self, gain: float) -> None:
        self._controller.gain = checked_gain("gain", gain)


class FeedbackAssist(_Assisted, Wrapper):
    """Adds the feedback controller's action to that of any agent.

        u = clip(u_agent + K u_fb, -1, 1)

    With K = 1 an agent that returns zeros already follows the demonstration, and learns only the
    residual. `gain` may be changed at any time, such as from episode to episode.

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
            BadOptionError: The gain is not between 0 and 1, or the interface is not dm_env's.
        """
        super().__init__(env)
        self._controller = _Controller(
            gain, self.task.max_joint_speed, self.control_timestep(), self.task.kinematics
        )
        self.last_action = self.last_feedback = np.zeros(8)

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act with the help of the feedback controller.

        Args:
            action: The agent's action, shape (8,).
        """
        assisted, feedback = self._controller.assist(action)
        timestep = super().step(assisted)
        if not timestep.first():
            self.last_action, self.last_feedback = clip(assisted), feedback
        return timestep

    def _on_begin(self, timestep: dm_env.TimeStep) -> None:
        self._controller.observe(timestep.observation)

    def _on_step(self, timestep: dm_env.TimeStep) -> None:
        self._controller.observe(timestep.observation)


class GymFeedbackAssist(_Assisted, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """`FeedbackAssist` for an environment of `gymnasium.make`, flat or not.

    `info["feedback"]` is the controller's part K u_fb of the step, shape (8,).
    """

    def __init__(self, env: gymnasium.Env[Any, Any], gain: float = 1.0) -> None:
        """Wrap an environment.

        Args:
            env: Environment that `gymnasium.make` returned, perhaps wrapped.
            gain: Gain K of the feedback controller.

        Raises:
            BadOptionError: The gain is not between 0 and 1, or the environment is another.
        """
        self._inner = unwrap(env, ImitationEnv)
        self._controller = _Controller(
            gain,
            self._inner.max_joint_speed,
            self._inner.control_timestep,
            self._inner.physics.kinematics,
        )
        RecordConstructorArgs.__init__(self, gain=gain)
        gymnasium.Wrapper.__init__(self, env)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see `ImitationEnv.reset`."""
        observation, info = super().reset(seed=seed, options=options)
        self._controller.observe(self._inner.last_observation)
        return observation, info

    def step(self, action: ArrayLike) -> Any:
        """Act with the help of the feedback controller; see `ImitationEnv.step`.

        Args:
            action: The agent's action, shape (8,).
        """
        assisted, feedback = self._controller.assist(action)
        *outcome, info = super().step(assisted)
        self._controller.observe(self._inner.last_observation)
        return *outcome, info | {"feedback": feedback}


class VectorFeedbackAssist(_Assisted, VectorWrapper):
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
            BadOptionError: The gain is not between 0 and 1, or the environments are others.
        """
        self._inner = unwrap(env, VectorImitationEnv)
        self._controller = _Controller(
            gain,
            self._inner.max_joint_speed,
            self._inner.control_timestep,
            self._inner.arms.kinematics,
            self._inner.num_envs,
        )
        super().__init__(env)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of every environment; see `VectorImitationEnv.reset`."""
        observations, info = super().reset(seed=seed, options=options)  # type: ignore[arg-type] # None too
        self._controller.observe(self._inner.last_observation)
        return observations, info

    def step(self, actions: ArrayLike) -> Any:
        """Act with the help of the feedback controller; see `VectorImitationEnv.step`.

        Args:
            actions: The agents' actions, shape (N, 8).
        """
        assisted, feedback = self._controller.assist(actions)
        *outcome, info = super().step(assisted)
        self._controller.observe(self._inner.last_observation)
        every = np.ones(self.num_envs, bool)
        return *outcome, info | {"feedback": feedback, "_feedback": every}


def checked_gain(option: str, gain: Any) -> float:
    """Return the gain of the feedback controller, given the name of its option.

    Raises:
        BadOptionError: It is not between 0 and 1.
    """
    if not is_within(_GAIN, gain):
        raise BadOptionError(option=option, value=gain, expected="0 to 1")
    return float(gain)
