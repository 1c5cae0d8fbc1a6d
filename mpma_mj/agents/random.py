"""The agent that any other has to beat."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Observation, Seeds
from mpma_mj.agents.fixed import FixedAgent
from mpma_mj.utils.seeding import stream

__all__ = ["RandomAgent"]

Array = NDArray[np.float64]

_JOINTS = 8


class RandomAgent(FixedAgent):
    """Acts at random, uniformly in [-1, 1], whatever it sees."""

    def __init__(self, *, seed: Seeds = 0) -> None:
        """Begin with episode 0.

        Args:
            seed: Seed of the actions; several are agents side by side.
        """
        self._shape = (*np.shape(seed), _JOINTS)
        self._seeds: list[int] = np.ravel(seed).tolist()
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with that episode's own random numbers."""
        self._streams = [stream(seed, "random_action", episode) for seed in self._seeds]

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only, (R',) of R."""
        self._seeds = [self._seeds[i] for i in runs]
        self._shape = (*runs.shape, _JOINTS)

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        drawn = [own.uniform(-1.0, 1.0, _JOINTS) for own in self._streams]
        return np.reshape(drawn, self._shape)
