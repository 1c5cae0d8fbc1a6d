"""The vector environment behind Stable-Baselines3's own interface for vectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

__all__ = ["StableVecEnv", "policy_inputs"]

Array = NDArray[np.float64]


def policy_inputs(observation: Mapping[str, Array]) -> NDArray[np.float32]:
    """Return what a policy sees, shape (..., 52 + C + 12): the flat observation and the way to go.

    Posture and target are nearly the same, and only their difference tells where to go: given as
    such, normalisation makes it as large as anything else.
    """
    way = observation["target"] - observation["posture"]
    return np.concatenate([*observation.values(), way], axis=-1).astype(np.float32)


class StableVecEnv(VecEnv):
    """Hands on flat observations, and begins episodes where Stable-Baselines3 expects it.

    Gymnasium's environments begin the next episode at the step after the last,
    Stable-Baselines3's at the last step itself, with the last observation in `info`. All members
    dance the same number of steps, so one reset serves all. If one diverges it is out of step
    from then on; each member then spends a step without reward on beginning an episode.
    """

    def __init__(self, env: Any) -> None:
        """Take environments of `mpma_mj.make_vec` with dictionaries as observations."""
        self._env = env
        observation, _ = env.reset()
        size = policy_inputs(observation).shape[1]
        super().__init__(env.num_envs, Box(-np.inf, np.inf, (size,)), env.single_action_space)

    def reset(self) -> Array:
        """Begin an episode of every member; the first one of its seed, if one was set."""
        seeds = None if None in self._seeds else self._seeds
        self._reset_seeds()
        observation, _ = self._env.reset(seed=seeds)
        return policy_inputs(observation)

    def step_async(self, actions: Array) -> None:
        """Remember the actions, shape (N, 8)."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, NDArray[np.bool_], list[dict[str, Any]]]:
        """Act; return observations, rewards, which episodes are over, and what else there is."""
        seen, rewards, terminated, truncated, _ = self._env.step(self._actions)
        observation, over = policy_inputs(seen), terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row in np.flatnonzero(over):
            infos[row]["terminal_observation"] = observation[row]
            infos[row]["TimeLimit.truncated"] = bool(truncated[row])
        if over.all():
            observation = self.reset()
        return observation, rewards, over, infos

    def close(self) -> None:
        """End the threads."""
        self._env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute, the same for every member."""
        return [getattr(self._env, attr_name)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: members are no objects of their own."""
        raise TypeError("members of make_vec are no objects of their own")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Refuse: members are no objects of their own."""
        raise TypeError("members of make_vec are no objects of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> Sequence[bool]:
        """Return that no member is wrapped."""
        return [False] * self.num_envs
