"""How well arms track, whoever moves them."""

from __future__ import annotations

from typing import Any

import dm_env
import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.wrappers.base import Wrapper
from mpma_mj.envs.wrappers.episode_metrics import EpisodeRecorder
from mpma_mj.envs.wrappers.unwrapping import unwrap
from mpma_mj.utils.clipping import clip

__all__ = ["Evaluate", "GymEvaluate"]

Array = NDArray[np.float64]


class Evaluate(Wrapper):
    """Measures every episode that is danced to its end, and changes nothing.

    Put it outermost, so that it sees a `FeedbackAssist`, if there is one.

    Attributes:
        episode_metrics: For each episode that ended, by name: `p_e_percent`, `mpkpe_m` and
            `mean_reward` (see `metrics`); `steps`, how long it was; `terminated`, whether it ended
            before the demonstration did, as when the simulation diverges; and `feedback_ratio`
            where `FeedbackAssist` is at work. An episode that is left by `reset` does not count.
    """

    def __init__(self, env: dm_env.Environment) -> None:
        """Wrap an environment, which may be a wrapper itself."""
        super().__init__(env)
        self.episode_metrics: list[dict[str, float]] = []
        self._recorder = EpisodeRecorder()

    def _begun(self, timestep: dm_env.TimeStep) -> None:
        self._recorder = EpisodeRecorder()

    def _stepped(self, action: Array, timestep: dm_env.TimeStep) -> None:
        assist, env = {}, self._env
        if hasattr(env, "last_feedback"):
            assist = {"feedback": env.last_feedback, "action": env.last_action}
        self._recorder.add(
            env.physics, timestep.observation["reference"], timestep.reward, **assist
        )
        if timestep.last():
            terminated = timestep.discount == 0.0
            measures = self._recorder.measures(env.physics, terminated=terminated)
            self.episode_metrics.append(measures)


class GymEvaluate(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """`Evaluate` for an environment of `gymnasium.make`, flat or not.

    Put it outermost, so that it sees a `GymFeedbackAssist`, if there is one.

    Attributes:
        episode_metrics: As of `Evaluate`.
    """

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        """Wrap an environment.

        Args:
            env: Environment that `gymnasium.make` returned, perhaps wrapped.

        Raises:
            BadOptionError: It is another environment.
        """
        self._inner = unwrap(env, ImitationEnv)
        RecordConstructorArgs.__init__(self)
        gymnasium.Wrapper.__init__(self, env)
        self.episode_metrics: list[dict[str, float]] = []
        self._recorder = EpisodeRecorder()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; see `ImitationEnv.reset`."""
        self._recorder = EpisodeRecorder()
        return super().reset(seed=seed, options=options)

    def step(self, action: Any) -> Any:
        """Act; see `ImitationEnv.step`."""
        observation, reward, terminated, truncated, info = super().step(action)
        physics, assist = self._inner.physics, {}
        if "feedback" in info:
            assist = {"feedback": info["feedback"], "action": clip(self._inner.last_action)}
        self._recorder.add(
            physics, self._inner.last_observation["reference"], float(reward), **assist
        )
        if terminated or truncated:
            self.episode_metrics.append(self._recorder.measures(physics, terminated=terminated))
            self._recorder = EpisodeRecorder()
        return observation, reward, terminated, truncated, info
