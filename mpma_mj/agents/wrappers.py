"""Wrappers of agents: learning switched off, and an altered context."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent, AgentSignals, Observation, Seeds
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.context import active_label, one_hot
from mpma_mj.errors import BadOptionError, StateError
from mpma_mj.options import ContextSignal
from mpma_mj.utils.seeding import stream

if TYPE_CHECKING:
    import dm_env

__all__ = [
    "AgentWrapper",
    "AlteredContext",
    "Frozen",
    "altered_context",
    "altered_context_size",
    "paired_models_of",
]

Array = NDArray[np.float64]


class AgentWrapper(Agent):
    """An agent that passes all calls on to another; subclasses change some.

    Attributes:
        agent: The other agent.
    """

    def __init__(self, agent: Agent) -> None:
        """Wrap an agent."""
        super().__init__(agent.config, agent.spec, seed=agent.seed)
        self.agent = agent
        self.trainable, self.fine_tunable = agent.trainable, agent.fine_tunable
        self.has_modules, self.observes_plant = agent.has_modules, agent.observes_plant

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self.agent.reset(episode)

    def observe_plant(self, plant: NDArray[np.intp] | None) -> None:
        """Pass on which plant is on."""
        self.agent.observe_plant(plant)

    def act(self, observation: Observation) -> Array:
        """Return the agent's action, shape (..., 8)."""
        return self.agent.act(observation)

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Pass on the outcome of the action."""
        self.agent.observe(timestep)

    def learn(self) -> dict[str, Array]:
        """Let the agent learn; return the values that it logs."""
        return self.agent.learn()

    def signals(self) -> AgentSignals:
        """Return the agent's signals."""
        return self.agent.signals()

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self.agent.select_runs(runs)

    def state_dict(self) -> dict[str, Array]:
        """Return the agent's arrays by name."""
        return self.agent.state_dict()

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned."""
        self.agent.load_state_dict(state)


def paired_models_of(agent: Agent) -> PairedModels:
    """Return the agent with pairs of models inside all wrappers.

    Raises:
        BadOptionError: The agent has no forward models.
    """
    while isinstance(agent, AgentWrapper):
        agent = agent.agent
    if not isinstance(agent, PairedModels):
        expected = "an agent with forward models"
        raise BadOptionError(option="agent", value=type(agent).__name__, expected=expected)
    return agent


class Frozen(AgentWrapper):
    """An agent that learns nothing, whether at steps or after an episode."""

    def __init__(self, agent: Agent) -> None:
        """Wrap an agent."""
        super().__init__(agent)
        self.trainable = self.fine_tunable = False

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Do not pass on the outcome, from which the agent could learn."""

    def learn(self) -> dict[str, Array]:
        """Learn nothing."""
        return {}


class AlteredContext(AgentWrapper):
    """An agent that receives an altered context."""

    def __init__(
        self, agent: Agent, context_signal: ContextSignal, context: Array, period: int, seed: Seeds
    ) -> None:
        """Wrap an agent.

        Args:
            agent: The agent; its context has the size that `altered_context_size` returns.
            context_signal: What it receives; see `altered_context`.
            context: Context of an episode, shape (T, C).
            period: Steps from one repetition of the motion to the next.
            seed: Seed of the order, where it is shuffled; several are a batch of runs.

        Raises:
            BadOptionError: There is no such context signal.
        """
        super().__init__(agent)
        self._signal, self._context, self._period = context_signal, context, period
        self._seeds = np.asarray(seed)
        self._contexts = self._altered(0)  # (T, ..., C')
        self._step = 0

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self._contexts = self._altered(episode)
        self._step = 0

    def act(self, observation: Observation) -> Array:
        """Return the agent's action for the altered context.

        Raises:
            StateError: The episode has no further step.
        """
        if self._step >= len(self._contexts):
            raise StateError("act() was called after the end of the episode; call reset() first")
        context = self._contexts[self._step]
        self._step += 1
        return super().act(dict(observation) | {"context": context})

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        super().select_runs(runs)
        self._seeds = self._seeds[runs]

    def _altered(self, episode: int) -> Array:
        contexts = [
            altered_context(
                self._context, self._signal, self._period, stream(seed, "hearing", episode)
            )
            for seed in np.ravel(self._seeds).tolist()
        ]
        moments = np.stack(contexts, axis=1)  # (T, R, C')
        return moments.reshape(len(moments), *self._seeds.shape, -1)


def altered_context_size(context_signal: ContextSignal, labels: int) -> int:
    """Return the size of the altered context of a motion with a number of labels."""
    return 2 * labels if context_signal == "halves" else labels


def altered_context(
    context: Array, context_signal: ContextSignal, period: int, rng: np.random.Generator
) -> Array:
    """Return the altered context of an episode.

    Args:
        context: The motion's labels, one-hot, shape (T, C).
        context_signal: "labels", the same; "nothing", zeros; "constant", ones; "shuffled", the
            steps in random order; "halves", labels twice as fine: the first half of each stretch
            of a label, and the second.
        period: Steps from one repetition of the motion to the next, where stretches end.
        rng: Source of the order.

    Returns:
        Shape (T, C), of halves (T, 2C).

    Raises:
        BadOptionError: There is no such context signal.
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
    expected = f"one of {', '.join(get_args(ContextSignal))}"
    raise BadOptionError(option="context_signal", value=context_signal, expected=expected)


def _halves(context: Array, period: int) -> Array:
    """Return labels twice as fine, shape (T, 2C); zeros where there is no label."""
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
