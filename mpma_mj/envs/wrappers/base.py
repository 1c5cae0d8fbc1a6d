"""Base class of wrappers with dm_env's interface, and access to environments in Gymnasium's."""

from __future__ import annotations

from typing import Any, TypeVar

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError

__all__: list[str] = ["Wrapper", "unwrap"]

Array = NDArray[np.float64]
Env = TypeVar("Env", ImitationEnv, VectorImitationEnv)

_MAKERS = {
    ImitationEnv: 'gymnasium.make("mpma_mj:TwoArmImitation-v0")',
    VectorImitationEnv: "mpma_mj.make_vec(…)",
}


class Wrapper(dm_env.Environment):
    """Forwards everything to the environment inside, `physics` and `task` too.

    A subclass overrides `_on_begin` and `_on_step`, or `reset` and `step` themselves. `step` begins
    an episode where the one before has ended, as in dm_env; the hooks are called accordingly.
    """

    def __init__(self, env: dm_env.Environment) -> None:
        """Wrap an environment.

        Args:
            env: Environment that `mpma_mj.load` returned, perhaps wrapped.

        Raises:
            BadOptionError: The environment has another interface than dm_env's.
        """
        if not isinstance(env, dm_env.Environment):
            raise BadOptionError(
                option="env",
                value=env,
                expected="an environment of mpma_mj.load",
                remedy="for Gymnasium use GymEvaluate, GymFeedbackAssist or VectorFeedbackAssist",
            )
        self._env = env

    def __getattr__(self, name: str) -> Any:
        if name == "_env":  # looked up by copy and pickle before it is set
            raise AttributeError(name)
        return getattr(self._env, name)

    def reset(self) -> dm_env.TimeStep:
        """Begin an episode."""
        timestep = self._env.reset()
        self._on_begin(timestep)
        return timestep

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act; begin an episode where the one before has ended.

        Args:
            action: Action, shape (8,), in [-1, 1].
        """
        timestep = self._env.step(action)
        if timestep.first():
            self._on_begin(timestep)
        else:
            self._on_step(timestep)
        return timestep

    def action_spec(self) -> Any:
        """Return the specification of actions."""
        return self._env.action_spec()

    def observation_spec(self) -> Any:
        """Return the specifications of the observation's arrays."""
        return self._env.observation_spec()

    def reward_spec(self) -> Any:
        """Return the specification of rewards."""
        return self._env.reward_spec()

    def discount_spec(self) -> Any:
        """Return the specification of discounts."""
        return self._env.discount_spec()

    def close(self) -> None:
        """Close the environment inside."""
        self._env.close()

    def _on_begin(self, timestep: dm_env.TimeStep) -> None:
        """Process the first moment of an episode."""

    def _on_step(self, timestep: dm_env.TimeStep) -> None:
        """Process a step of an episode."""


def unwrap(env: Any, kind: type[Env]) -> Env:
    """Return the environment inside all of Gymnasium's wrappers.

    Args:
        env: Environment, perhaps wrapped.
        kind: Class of the environment inside.

    Raises:
        BadOptionError: The environment inside is of another class.
    """
    inner = getattr(env, "unwrapped", env)
    if not isinstance(inner, kind):
        expected = f"an environment of {_MAKERS[kind]}"
        raise BadOptionError(option="env", value=inner, expected=expected)
    return inner
