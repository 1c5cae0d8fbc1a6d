"""Evaluation and fine-tuning of trained agents under a condition."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.wrappers import Frozen
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.factory import make_environments, one_thread
from mpma_mj.training.rollout import rollout

__all__ = [
    "EVALUATION_EPISODE",
    "EvalCondition",
    "evaluate",
    "fine_tune",
    "learn_episodes",
    "posture_errors_percent",
]

Array = NDArray[np.float64]

EVALUATION_EPISODE = 1000
"""Number of the episode of an evaluation; no epoch of training has its noise (choice)."""


@dataclass(frozen=True, eq=False)
class EvalCondition:
    """Motion and environment of an evaluation.

    Attributes:
        name: Name of the condition.
        motion: The motion; its context has as many labels as in training.
        options: Options of the environment that differ from those of training, by name.
    """

    name: str
    motion: Motion
    options: Mapping[str, Any]


def evaluate(trained: TrainedAgents, condition: EvalCondition) -> list[Trace | None]:
    """Run an episode without learning; return each agent's trace, None where it diverged.

    Raises:
        MpmaError: The arms cannot follow the motion, or an option is out of bounds.
    """
    with one_thread(), contextlib.closing(_environments(trained, condition)) as envs:
        recorded = rollout(envs, Frozen(trained.agent(envs)), EVALUATION_EPISODE)
    return [recorded.of_run(run) for run in range(len(trained.configs))]


def fine_tune(
    trained: TrainedAgents, condition: EvalCondition, epochs: int
) -> tuple[TrainedAgents, Array]:
    """Train R agents that can learn for E more epochs, under a condition.

    Returns:
        The agents after the last epoch, and p_e of each epoch before the agents learn from it,
        shape (E, R), percent; NaN from the epoch on in which the simulation diverged.

    Raises:
        MpmaError: As of `evaluate`.
    """
    first = EVALUATION_EPISODE + 1
    with one_thread(), contextlib.closing(_environments(trained, condition)) as envs:
        agent = trained.agent(envs)
        errors = learn_episodes(envs, agent, range(first, first + epochs))
        return dataclasses.replace(trained, state=agent.state_dict()), errors


def learn_episodes(envs: VectorImitationEnv, agent: Agent, episodes: range) -> Array:
    """Let R agents learn from episodes.

    Args:
        envs: R environments.
        agent: The agents.
        episodes: Numbers of the E episodes.

    Returns:
        p_e of each episode before the agents learn from it, shape (E, R), percent; NaN from the
        episode on in which the simulation diverged.
    """
    errors = np.full((len(episodes), envs.num_envs), np.nan)
    failed = np.zeros(envs.num_envs, bool)
    for row, episode in zip(errors, episodes, strict=True):
        recorded = rollout(envs, agent, episode)
        failed[list(recorded.failures)] = True
        if failed.all():  # nothing to learn from
            break
        traces = [recorded.of_run(run) for run in range(len(failed))]
        row[:] = np.where(failed, np.nan, posture_errors_percent(traces))
        agent.learn()
    return errors


def posture_errors_percent(traces: Sequence[Trace | None]) -> Array:
    """Return p_e of each trace, shape (R,), percent; NaN where there is none."""
    return np.array(
        [
            np.nan if t is None else posture_error_percent(t.posture[1:], t.reference[1:])
            for t in traces
        ]
    )


def _environments(trained: TrainedAgents, condition: EvalCondition) -> VectorImitationEnv:
    return make_environments(trained.configs[0], trained.seeds, condition.motion, condition.options)
