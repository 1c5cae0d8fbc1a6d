"""Tracking metrics of every episode, whichever agent acts."""

from __future__ import annotations

from typing import Any

import dm_env
import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.wrappers.base import Wrapper, unwrap
from mpma_mj.utils.clipping import clip

__all__: list[str] = ["Evaluate", "GymEvaluate"]

Array = NDArray[np.float64]


class _Recorder:
    """Recorder of the steps of an episode, and of the metrics of those that end."""

    def __init__(self) -> None:
        self.episode_metrics: list[dict[str, float]] = []
        self._rewards: list[float] = []
        self._assists: list[dict[str, Array]] = []

    def begin(self) -> None:
        """Forget the steps of an episode that has not ended."""
        self._rewards, self._assists = [], []

    def add(self, reward: float, assist: dict[str, Array]) -> None:
        """Record a step.

        Args:
            reward: Reward of the step.
            assist: `feedback` and `action` of a feedback controller that assists, each shape
                (8,); empty without one.
        """
        self._rewards.append(reward)
        self._assists.append(assist)

    def end(self, errors: dict[str, float], *, terminated: bool) -> dict[str, float]:
        """Return the metrics of the episode, and keep them.

        Args:
            errors: Tracking errors of the episode; see `metrics.tracking_errors`.
            terminated: Whether it ended before the demonstration did.
        """
        measures = errors | {
            "mean_reward": float(np.mean(self._rewards)),
            "steps": len(self._rewards),
        }
        if self._assists[0]:
            feedback, action = (
                np.stack([assist[name] for assist in self._assists])
                for name in ("feedback", "action")
            )
            measures["feedback_ratio"] = metrics.feedback_ratio(feedback, action)
        self.episode_metrics.append(measures | {"terminated": terminated})
        self.begin()
        return self.episode_metrics[-1]


class Evaluate(Wrapper):
    """Computes metrics of every episode that ends, and changes nothing.

    It must be the outermost wrapper, around a `FeedbackAssist` if there is one.

    Attributes:
        episode_metrics: For each episode that ended, by name: `p_e_percent`, `mpkpe_m` and
            `mean_reward` (see `metrics`); `steps`, its length; `terminated`, whether it ended
            before the demonstration did, as when the simulation diverges; and `feedback_ratio`
            with a `FeedbackAssist`. An episode that `reset` breaks off does not count.
    """

    def __init__(self, env: dm_env.Environment) -> None:
        """Wrap an environment; see `Wrapper`."""
        super().__init__(env)
        self._recorder = _Recorder()
        self.episode_metrics = self._recorder.episode_metrics

    def _on_begin(self, timestep: dm_env.TimeStep) -> None:
        self._recorder.begin()

    def _on_step(self, timestep: dm_env.TimeStep) -> None:
        assist, env = {}, self._env
        if hasattr(env, "last_feedback"):
            assist = {"feedback": env.last_feedback, "action": env.last_action}
        self._recorder.add(timestep.reward, assist)
        if timestep.last():
            errors = env.task.tracking_errors(env.physics)
            self._recorder.end(errors, terminated=timestep.discount == 0.0)


class GymEvaluate(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """`Evaluate` for an environment of `gymnasium.make`, flat or not.

    The last `info` of an episode contains its metrics, also where a `TimeLimit` cuts it short. It
    must be the outermost wrapper, around a `GymFeedbackAssist` if there is one.

    Attributes:
        episode_metrics: As of `Evaluate`.
    """

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        """Wrap an environment.

        Args:
            env: Environment that `gymnasium.make` returned, perhaps wrapped.

        Raises:
            BadOptionError: The environment is another.
        """
        self._inner = unwrap(env, ImitationEnv)
        self._recorder = _Recorder()
        self.episode_metrics = self._recorder.episode_metrics
        RecordConstructorArgs.__init__(self)
        gymnasium.Wrapper.__init__(self, env)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see `ImitationEnv.reset`."""
        self._recorder.begin()
        return super().reset(seed=seed, options=options)

    def step(self, action: Any) -> Any:
        """Act; see `ImitationEnv.step`."""
        observation, reward, terminated, truncated, info = super().step(action)
        assist, inner = {}, self._inner
        if "feedback" in info:
            assist = {"feedback": info["feedback"], "action": clip(inner.last_action)}
        self._recorder.add(float(reward), assist)
        if terminated or truncated:
            info |= self._recorder.end(inner.tracking_errors(), terminated=terminated)
        return observation, reward, terminated, truncated, info
