"""What agents that never learn have in common."""

from __future__ import annotations

from collections.abc import Mapping

import dm_env
import numpy as np
from numpy.typing import NDArray

__all__ = ["FixedAgent"]

Array = NDArray[np.float64]


class FixedAgent:
    """An agent that learns nothing, so that there is nothing of it to save.

    A subclass gives it `act`, and whatever it has to keep in mind during an episode.
    """

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take no notice of what the action led to."""

    def learn(self) -> dict[str, float]:
        """Learn nothing; there is nothing to log."""
        return {}

    def learn_batch(self) -> list[dict[str, float]]:
        """Learn nothing."""
        return []

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only, (R',) of R, from the next reset.

        There is nothing to do: how many they are is seen from the observations, unless a subclass
        has something for each.
        """

    def signals(self) -> dict[str, Array]:
        """Return no signals."""
        return {}

    def state_dict(self) -> dict[str, Array]:
        """Return nothing: nothing is learned."""
        return {}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Go on as before: nothing is learned."""
