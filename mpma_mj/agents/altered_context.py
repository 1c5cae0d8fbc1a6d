"""Agents that hear something else than which part of the dance is on."""

from __future__ import annotations

from typing import get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent, BatchedAgent, Observation, Seeds
from mpma_mj.agents.wrapper import AgentWrapper
from mpma_mj.context import active_label, one_hot
from mpma_mj.errors import BadOptionError
from mpma_mj.options import ContextSignal
from mpma_mj.utils.seeding import stream

__all__ = ["AlteredContext", "altered_context", "altered_context_size"]

Array = NDArray[np.float64]


def altered_context_size(context_signal: ContextSignal, labels: int) -> int:
    """Return the size of the context that is heard, of a movement with so many labels."""
    return 2 * labels if context_signal == "halves" else labels


def altered_context(
    context: Array, context_signal: ContextSignal, period: int, rng: np.random.Generator
) -> Array:
    """Return what is heard in an episode.

    Args:
        context: Which label is danced, shape (T, C).
        context_signal: "labels", as it is; "nothing", silence; "constant", one sound throughout;
            "shuffled", the labels of the moments in any order; "halves", labels twice as fine:
            the first half of each stretch of a label, and the second.
        period: Steps from one repetition of the movement to the next, where stretches end.
        rng: Source of the order.

    Returns:
        Shape (T, C), of halves (T, 2C).

    Raises:
        BadOptionError: There is nothing of that name to hear.
    """
    if context_signal == "labels":
        return context
    if context_signal == "nothing":
        return np.zeros_like(context)
    if context_signal == "constant":
        return np.ones_like(context)
    if context_signal == "shuffled":
        return rng.permutation(context, axis=0)
    if context_signal == "halves":
        return _halves(context, period)
    expected = ", ".join(get_args(ContextSignal))
    raise BadOptionError(f"context_signal is {context_signal!r}; expected one of {expected}")


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


class AlteredContext(AgentWrapper):
    """An agent between which and the context something stands; in all else that agent."""

    def __init__(
        self,
        agent: Agent,
        context_signal: ContextSignal,
        context: Array,
        period: int,
        seed: Seeds,
    ) -> None:
        """Stand between.

        Args:
            agent: The agent; its context has the size that `altered_context_size` returns.
            context_signal: What it hears; see `altered_context`.
            context: Context of all moments of an episode, shape (T, C).
            period: Steps from one repetition of the movement to the next.
            seed: Seed of the order, where it is shuffled; several for agents side by side.

        Raises:
            BadOptionError: There is nothing of that name to hear.
        """
        super().__init__(agent)
        self._signal, self._context, self._period = context_signal, context, period
        self._seeds = np.asarray(seed)
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        heard = [
            altered_context(
                self._context, self._signal, self._period, stream(own, "hearing", episode)
            )
            for own in np.ravel(self._seeds).tolist()
        ]
        moments = np.stack(heard, axis=1)  # (T, R, C')
        self._contexts = iter(moments.reshape(len(moments), *self._seeds.shape, -1))

    def act(self, observation: Observation) -> Array:
        """Return the action of the agent with the altered context."""
        return super().act(dict(observation) | {"context": next(self._contexts)})

    def learn_batch(self) -> list[dict[str, float]]:
        """Let the agents side by side learn."""
        assert isinstance(self.agent, BatchedAgent)
        return self.agent.learn_batch()

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Go on with some of the agents side by side only, (R',) of R."""
        assert isinstance(self.agent, BatchedAgent)
        self.agent.select_runs(runs)
        self._seeds = self._seeds[runs]
