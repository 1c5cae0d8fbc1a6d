"""Vector of environments as Stable-Baselines3 expects it.

from mpma_mj.envs.sb3 import make_sb3_vec
env = make_sb3_vec(16, "ymca", feedback_gain=1.0)
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.options import check_names, check_seed
from mpma_mj.envs.vector_conventions import check_no_options, row_of
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.envs.wrappers import VectorFeedbackAssist
from mpma_mj.envs.wrappers.base import unwrap
from mpma_mj.envs.wrappers.feedback_assist import checked_gain
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion

try:
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor
except ImportError as error:
    raise ImportError(
        "mpma_mj.envs.sb3 needs Stable-Baselines3, which is not installed; pip install"
        " 'mpma-mj[sb3]', in a checkout pip install -e '.[sb3]'"
    ) from error

__all__: list[str] = ["LOGGED", "SB3VecEnv", "make_sb3_vec"]

LOGGED = ("p_e_percent", "mpkpe_m", "termination_reason")
"""Entries of an episode's last `info` that `make_sb3_vec` logs with its return and length."""

_OF_EACH = ("drawn", "episode", "latency", "plant", "posture")
"""Attributes with a row for each environment."""


class SB3VecEnv(VecEnv):
    """Vector of environments behind Stable-Baselines3's interface.

    Observations and rewards are float32, as its policies compute. The `info` of an episode's last
    step is that of `ImitationEnv`, with `terminal_observation`; that of other steps contains
    `TimeLimit.truncated` alone, which costs less.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any]) -> None:
        """Wrap environments.

        Args:
            env: Environments of `make_vec`, perhaps in wrappers, that begin episodes at the same
                step.

        Raises:
            BadOptionError: Episodes begin at the next step, or not by themselves; or environments
                of another kind are wrapped.
        """
        unwrap(env, VectorImitationEnv)
        mode = env.metadata["autoreset_mode"]
        if mode is not AutoresetMode.SAME_STEP:
            raise BadOptionError(option="autoreset_mode", value=mode.name, expected="SAME_STEP")
        self.envs = env
        space = env.single_observation_space
        super().__init__(env.num_envs, _as_float32_space(space), env.single_action_space)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Set the seed of the first environment, from which the others' follow, for `reset`."""
        return super().seed(None if seed is None else check_seed(seed))

    def reset(self) -> Any:
        """Begin the next episode of every environment, or the first one of its seed."""
        for own in self._options if isinstance(self._options, list) else [self._options]:
            check_no_options(own)
        observations, info = self.envs.reset(seed=self._seeds)
        self._reset_seeds()
        self.reset_infos = [row_of(info, row) for row in range(self.num_envs)]
        return _as_float32(observations)

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions, shape (N, 8), for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Act; return observations, rewards, which episodes are over, and a list of `info`."""
        observations, rewards, terminated, truncated, info = self.envs.step(self._actions)
        over = terminated | truncated
        infos: list[dict[str, Any]] = [{"TimeLimit.truncated": False} for _ in over]
        for row in np.flatnonzero(over).tolist():
            infos[row] = row_of(info["final_info"], row) | {
                "TimeLimit.truncated": bool(truncated[row]),
                "terminal_observation": _as_float32(info["final_obs"][row]),
            }
            self.reset_infos[row] = row_of(
                {name: entry for name, entry in info.items() if "final_" not in name}, row
            )
        return _as_float32(observations), rewards.astype(np.float32), over, infos

    def close(self) -> None:
        """Close the environments."""
        self.envs.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """Return a picture of each environment, which `render` puts into a grid."""
        pictures: Any = self.envs.render()
        return pictures or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute for each environment: its own row, or what all have."""
        value = getattr(self._owner(attr_name), attr_name)
        rows = self._get_indices(indices)
        if attr_name not in _OF_EACH or value is None:
            return [value for _ in rows]
        if isinstance(value, dict):
            return [{name: part[row] for name, part in value.items()} for row in rows]
        return [value[row] for row in rows]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of all environments, such as the `gain` of feedback.

        Raises:
            AttributeError: There is no such attribute.
            BadOptionError: Only some environments are to have it.
        """
        if indices is not None:
            raise BadOptionError(
                option="indices", value=indices, expected="None, as all share their attributes"
            )
        setattr(self._owner(attr_name), attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of all environments at once; return its result for each."""
        result = getattr(self._owner(method_name), method_name)(*method_args, **method_kwargs)
        own = isinstance(result, tuple) and len(result) == self.num_envs
        return [result[row] if own else result for row in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return that no environment has a wrapper of its own."""
        return [False for _ in self._get_indices(indices)]

    def _owner(self, name: str) -> Any:
        """Return the outermost of wrappers and environments with an attribute."""
        env: Any = self.envs
        while not hasattr(env, name) and env is not env.unwrapped:
            env = env.env
        getattr(env, name)  # or its own error
        return env


def make_sb3_vec(
    num_envs: int,
    motion: Motion | str | Path = "ymca",
    *,
    feedback_gain: float = 0.0,
    **options: Any,
) -> VecMonitor:
    """Return environments to train in with Stable-Baselines3.

    Args:
        num_envs: Number N of environments.
        motion: The motion, or its name, such as "ymca", or the path of a recording.
        feedback_gain: Gain of the feedback controller whose action is added to the policy's, 0 to
            1; see `VectorFeedbackAssist`.
        **options: Further arguments of `mpma_mj.make_vec`; observations are flat unless it is
            `flat=False`.

    Returns:
        `SB3VecEnv` in a `VecMonitor`, which logs return, length and `LOGGED` of episodes.

    Raises:
        BadOptionError: An option is out of bounds, or does not exist.
        MpmaError: The motion cannot be read.
    """
    gain = checked_gain("feedback_gain", feedback_gain)
    check_names(options, ("feedback_gain", *inspect.signature(make_vec).parameters))
    if "autoreset_mode" in options:
        problem = "Stable-Baselines3 begins episodes at the same step"
        raise BadOptionError(problem, remedy="leave out {autoreset_mode}")
    given: dict[str, Any] = {"flat": True, "autoreset_mode": AutoresetMode.SAME_STEP} | options
    envs: VectorEnv[Any, Any, Any] = make_vec(num_envs, motion, **given)
    if gain > 0.0:
        envs = VectorFeedbackAssist(envs, gain)
    return VecMonitor(SB3VecEnv(envs), info_keywords=LOGGED)


def _as_float32(observation: Any) -> Any:
    if isinstance(observation, dict):
        return {name: part.astype(np.float32) for name, part in observation.items()}
    return observation.astype(np.float32)


def _as_float32_space(space: spaces.Space[Any]) -> spaces.Space[Any]:
    if isinstance(space, spaces.Dict):
        return spaces.Dict([(name, _as_float32_space(part)) for name, part in space.items()])
    assert isinstance(space, spaces.Box)
    return spaces.Box(space.low.astype(np.float32), space.high.astype(np.float32))
