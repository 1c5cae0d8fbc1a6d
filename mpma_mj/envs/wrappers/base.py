"""An environment around another, which it leaves as it is."""

from __future__ import annotations

from typing import Any

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError

__all__ = ["Wrapper"]

Array = NDArray[np.float64]


class Wrapper(dm_env.Environment):
    """Hands everything on to the environment inside, `physics` and `task` too.

    A subclass overrides `_begun` and `_stepped`, or `reset` and `step` themselves. `step` begins
    an episode where the one before has ended, as dm_env has it: subclasses need not care.
    """

    def __init__(self, env: dm_env.Environment) -> None:
        """Wrap an environment, which may be a wrapper itself.

        Raises:
            BadOptionError: It has another interface than dm_env's.
        """
        if not isinstance(env, dm_env.Environment):
            raise BadOptionError(
                f"env is {env}; expected what mpma_mj.load returned; for Gymnasium there are"
                " GymEvaluate, GymFeedbackAssist, VectorFeedbackAssist"
            )
        self._env = env

    def __getattr__(self, name: str) -> Any:
        if name == "_env":  # asked for before there is one, by copy and pickle
            raise AttributeError(name)
        return getattr(self._env, name)

    def reset(self) -> dm_env.TimeStep:
        """Begin an episode."""
        timestep = self._env.reset()
        self._begun(timestep)
        return timestep

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act; begin an episode where none is going on.

        Args:
            action: Action, shape (8,), in [-1, 1].
        """
        timestep = self._env.step(action)
        if timestep.first():
            self._begun(timestep)
        else:
            self._stepped(action, timestep)
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

    def _begun(self, timestep: dm_env.TimeStep) -> None:
        """Take notice of the first moment of an episode."""

    def _stepped(self, action: Array, timestep: dm_env.TimeStep) -> None:
        """Take notice of what an action led to."""
