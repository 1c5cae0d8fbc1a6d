"""What agents that never learn have in common."""

from __future__ import annotations

from collections.abc import Mapping

import dm_env
import numpy as np
from numpy.typing import NDArray

__all__ = ["FixedAgent"]

Array = NDArray[np.float64]


class FixedAgent:
    """An agent without state, signals and learning; a subclass gives it `act`."""

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take no notice of what the action led to."""

    def learn(self) -> dict[str, float]:
        """Learn nothing; there is nothing to log."""
        return {}

    def learn_side_by_side(self) -> list[dict[str, float]]:
        """Learn nothing."""
        return []

    def keep(self, members: NDArray[np.intp]) -> None:
        """Go on: one that keeps no account of its own side by side acts for any number."""

    def signals(self) -> dict[str, Array]:
        """Return no signals."""
        return {}

    def state_dict(self) -> dict[str, Array]:
        """Return nothing: nothing is learned."""
        return {}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Go on as before: nothing is learned."""
