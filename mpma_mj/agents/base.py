"""What an agent is to a training loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

import dm_env
import numpy as np
from numpy.typing import NDArray

__all__ = ["Agent", "BatchedAgent", "Observation", "Seeds"]

Array = NDArray[np.float64]
Observation = Mapping[str, Array]
Seeds = int | Sequence[int]


class Agent(Protocol):
    """Something that acts in episodes and learns between them.

    A loop calls `reset`, then `act` and `observe` in turn until the episode ends, then `learn`.
    Agents know no environment: they see observations and give actions.
    """

    def reset(self, episode: int) -> None:
        """Begin an episode; what is random in it depends on the agent's seed and its number."""

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (8,), in [-1, 1]."""

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Take in what the action led to."""

    def learn(self) -> dict[str, float]:
        """Learn from the episode that ended; return what is worth logging, by name.

        Of one agent: those that learn side by side refuse, and have `learn_batch`.
        """

    def signals(self) -> dict[str, Array]:
        """Return the agent's inner signals of the last episode by name, each (T, ...).

        There need not be any. `feedback`, (T, 8), is the feedback controller's part of the
        action; the measures of modules need all those that `MPMA.signals` names.
        """

    def state_dict(self) -> dict[str, Array]:
        """Return all that learning has changed, as arrays by name."""

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""


@runtime_checkable
class BatchedAgent(Agent, Protocol):
    """Agents side by side: all arrays have an axis R, and each acts and learns as alone."""

    def learn_batch(self) -> list[dict[str, float]]:
        """Let each learn from its episode, in place of `learn`; return what is worth logging.

        An entry for each agent, by name; none at all where agents do not learn.
        """

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents only, of numbers (R',)."""
