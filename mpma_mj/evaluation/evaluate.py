"""Trained agents in another condition: as they are, and as they learn on."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.wrappers import Frozen
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.factory import environments_of, one_thread
from mpma_mj.training.trace import record_epochs

__all__ = ["EVALUATION_EPISODE", "EvalCondition", "evaluate", "fine_tune", "tracking_errors"]

Array = NDArray[np.float64]
Trace = dict[str, Array]

EVALUATION_EPISODE = 1000
"""Number of a trial's episode; its noise is that of no epoch of training (choice)."""


@dataclass(frozen=True, eq=False)
class EvalCondition:
    """Where agents are tried.

    Attributes:
        name: What it is called.
        motion: What is demonstrated; its context has as many labels as the agents know.
        options: Options of the environment that are other than in training, by name.
    """

    name: str
    motion: Motion
    options: Mapping[str, Any]


def evaluate(trained: TrainedAgents, condition: EvalCondition) -> list[Trace | None]:
    """Let agents dance an episode as they have learned to.

    Args:
        trained: R agents.
        condition: Where.

    Returns:
        Signals of each agent as `record_epoch` returns them; None where the simulation diverged.

    Raises:
        MpmaError: The arms cannot follow the condition's movement, or there can be no such
            condition.
    """
    with one_thread(), contextlib.closing(_environments(trained, condition)) as envs:
        traces, diverged = record_epochs(envs, Frozen(trained.agent(envs)), EVALUATION_EPISODE)
    return [None if lost else trace for trace, lost in zip(traces, diverged, strict=True)]


def fine_tune(
    trained: TrainedAgents, condition: EvalCondition, epochs: int
) -> tuple[TrainedAgents, Array]:
    """Let agents learn on.

    Args:
        trained: R agents that can learn.
        condition: Where.
        epochs: Number E of epochs.

    Returns:
        The agents after the last epoch, and p_e of each epoch, danced before what is learned
        from it, shape (E, R), percent; NaN from the epoch on in which the simulation diverged, as
        what is learned then means nothing.

    Raises:
        MpmaError: As of `evaluate`.
    """
    errors = np.empty((epochs, len(trained.configs)))
    lost = np.zeros(len(trained.configs), bool)
    with one_thread(), contextlib.closing(_environments(trained, condition)) as envs:
        agent = trained.agent(envs)
        for epoch in range(epochs):
            traces, diverged = record_epochs(envs, agent, EVALUATION_EPISODE + 1 + epoch)
            lost |= diverged
            errors[epoch] = np.where(lost, np.nan, [_error(trace) for trace in traces])
            agent.learn()
        return dataclasses.replace(trained, state=agent.state_dict()), errors


def tracking_errors(traces: list[Trace | None]) -> Array:
    """Return p_e of each trace, shape (R,), percent; NaN where there is none."""
    return np.array([np.nan if trace is None else _error(trace) for trace in traces])


def _error(trace: Trace) -> float:
    return posture_error_percent(trace["posture"][1:], trace["reference"][1:])


def _environments(trained: TrainedAgents, condition: EvalCondition) -> VectorImitationEnv:
    return environments_of(trained.configs[0], trained.seeds, condition.motion, condition.options)
