"""Rollouts: episodes of one run or of a batch of runs, with every signal recorded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.base import Observation
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import DivergedError
from mpma_mj.trace import OBSERVED, Trace
from mpma_mj.training.environments import Environments, wrap

__all__ = ["Rollout", "record_epoch", "rollout"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rollout:
    """An episode of one run, or of R runs.

    Attributes:
        trace: Signals of the episode; not meaningful for runs that failed.
        failures: Why episodes ended before the demonstration, by run.
    """

    trace: Trace
    failures: dict[int, str]

    def of_run(self, run: int) -> Trace | None:
        """Return the trace of one run of a batch; None if it failed."""
        return None if run in self.failures else self.trace.of_run(run)


def rollout(envs: Environments, agent: Agent, epoch: int) -> Rollout:
    """Run an episode and record all its signals.

    The agent acts and observes. Only an agent that learns at every step learns meanwhile.

    Args:
        envs: Environments of one run, or of R runs; their next episode gets the number of the
            epoch.
        agent: Agent of as many runs.
        epoch: Number of the epoch, from 0.
    """
    agent.reset(epoch)
    timestep = envs.reset(epoch)
    moments, steps = EpisodeBuffer(), EpisodeBuffer()
    moments.append(_observed(timestep.observation, envs.posture()))
    failures: dict[int, str] = {}
    runs = envs.shape[0] if envs.shape else 1
    for step in range(1, envs.info.steps + 1):
        plant = envs.plant()
        if agent.is_told_plant:
            agent.tell_plant(plant)
        action = agent.act(timestep.observation)
        timestep = envs.step(action)
        agent.observe(timestep)
        moments.append(_observed(timestep.observation, envs.posture()))
        acted = {"action": action, "reward": np.asarray(timestep.reward)}
        steps.append(acted if plant is None else acted | {"plant": plant})
        for run, reason in envs.failures().items():
            failures.setdefault(run, f"{reason} at step {step}")
        if len(failures) == runs:
            break
    internal = agent.signals()
    recorded = moments.episode() | steps.episode()
    trace = Trace(**recorded, **vars(internal))
    return Rollout(trace, failures)


def record_epoch(env: control.Environment | VectorImitationEnv, agent: Agent, epoch: int) -> Trace:
    """Run an episode and return its trace, as `rollout` does.

    Args:
        env: Environment that `mpma_mj.load` returned, or those that `mpma_mj.make_vec` returned.
        agent: Agent of as many runs.
        epoch: Number of the epoch, from 0.

    Raises:
        DivergedError: An episode ended before the demonstration.
    """
    recorded = rollout(wrap(env), agent, epoch)
    for reason in recorded.failures.values():
        raise DivergedError(f"epoch {epoch + 1}: {reason}", remedy=TRY_INSTEAD)
    return recorded.trace


TRY_INSTEAD = "try a slower {tempo} or another {seed}"
"""Remedy for a simulation that diverges."""


def _observed(observation: Observation, posture: Array) -> dict[str, Array]:
    """Return the signals of a moment, with the true posture in place of the observed one.

    Args:
        observation: Observation of the agent.
        posture: True posture, shape (..., 12).
    """
    return {name: observation[name] for name in OBSERVED} | {"posture": posture}
