"""Agents that hear something else than which part of the dance is on."""

from __future__ import annotations

from typing import get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent import Agent, Observation, Seeds, SideBySide
from mpma_mj.agents.wrapper import AgentWrapper
from mpma_mj.context import active_label, one_hot
from mpma_mj.errors import BadOptionError
from mpma_mj.options import HearsName
from mpma_mj.utils.seeding import stream

__all__ = ["Hearing", "heard_size", "what_is_heard"]

Array = NDArray[np.float64]


def heard_size(hears: HearsName, labels: int) -> int:
    """Return the size of the context that is heard, of a movement with so many labels."""
    return 2 * labels if hears == "halves" else labels


def what_is_heard(context: Array, hears: HearsName, period: int, rng: np.random.Generator) -> Array:
    """Return what is heard in an episode.

    Args:
        context: Which label is danced, shape (T, C).
        hears: "labels", as it is; "nothing", silence; "constant", one sound throughout;
            "shuffled", the labels of the moments in any order; "halves", labels twice as fine:
            the first half of each stretch of a label, and the second.
        period: Steps from one repetition of the movement to the next, where stretches end.
        rng: Source of the order.

    Returns:
        Shape (T, C), of halves (T, 2C).

    Raises:
        BadOptionError: There is nothing of that name to hear.
    """
    if hears == "labels":
        return context
    if hears == "nothing":
        return np.zeros_like(context)
    if hears == "constant":
        return np.ones_like(context)
    if hears == "shuffled":
        return rng.permutation(context, axis=0)
    if hears == "halves":
        return _halves(context, period)
    raise BadOptionError(f"hears is {hears!r}; expected one of {', '.join(get_args(HearsName))}")


def _halves(context: Array, period: int) -> Array:
    """Return labels twice as fine, shape (T, 2C); where nothing is heard, nothing still."""
    label = active_label(context)
    changes = np.diff(label, prepend=-2) != 0
    changes[::period] = True  # else a label at both ends would make one stretch over the seam
    begins = np.flatnonzero(changes)
    fine = np.full(len(label), -1)
    for start, end in zip(begins, [*begins[1:], len(label)], strict=True):
        if label[start] >= 0:
            later = np.arange(start, end) >= (start + end) / 2
            fine[start:end] = 2 * label[start] + later
    return one_hot(fine, 2 * context.shape[1]) * (fine >= 0)[:, None]


class Hearing(AgentWrapper):
    """An agent between which and the context something stands; in all else that agent."""

    def __init__(
        self, agent: Agent, hears: HearsName, context: Array, period: int, seed: Seeds
    ) -> None:
        """Stand between.

        Args:
            agent: The agent; its context has the size that `heard_size` returns.
            hears: What it hears; see `what_is_heard`.
            context: Context of all moments of an episode, shape (T, C).
            period: Steps from one repetition of the movement to the next.
            seed: Seed of the order, where it is shuffled; several for agents side by side.

        Raises:
            BadOptionError: There is nothing of that name to hear.
        """
        super().__init__(agent)
        self._hears, self._context, self._period = hears, context, period
        self._seeds = np.asarray(seed)
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        heard = [
            what_is_heard(self._context, self._hears, self._period, stream(own, "hearing", episode))
            for own in np.ravel(self._seeds).tolist()
        ]
        moments = np.stack(heard, axis=1)  # (T, R, C')
        self._heard = iter(moments.reshape(len(moments), *self._seeds.shape, -1))

    def act(self, observation: Observation) -> Array:
        """Return the action of the agent that hears what it hears."""
        return super().act(dict(observation) | {"context": next(self._heard)})

    def learn_side_by_side(self) -> list[dict[str, float]]:
        """Let the agents side by side learn."""
        assert isinstance(self.agent, SideBySide)
        return self.agent.learn_side_by_side()

    def keep(self, members: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only, (R',) of R."""
        assert isinstance(self.agent, SideBySide)
        self.agent.keep(members)
        self._seeds = self._seeds[members]
