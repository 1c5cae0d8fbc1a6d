"""Rollouts: episodes of one run or of a batch of runs, with every signal recorded."""

from __future__ import annotations

from dataclasses import dataclass

import dm_env
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.base import Observation
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.envs.task import TwoArmImitation
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import DivergedError
from mpma_mj.trace import OBSERVED, Trace
from mpma_mj.training.factory import Environments

__all__ = ["TRY_INSTEAD", "Rollout", "record_epoch", "rollout"]

Array = NDArray[np.float64]

TRY_INSTEAD = "try a lower {tempo} or another {seed}"
"""Remedy for a simulation that diverges."""


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


def rollout(env: Environments, agent: Agent, epoch: int) -> Rollout:
    """Run an episode and record all its signals.

    The agent acts and observes. Only an agent that learns at every step learns meanwhile.

    Args:
        env: Environment of one run, or those of R runs; the next episode gets the number of the
            epoch.
        agent: Agent of as many runs.
        epoch: Number of the epoch, from 0.
    """
    envs = _Batch(env) if isinstance(env, VectorImitationEnv) else _Single(env)
    agent.reset(epoch)
    timestep = envs.reset(epoch)
    moments, steps = EpisodeBuffer(), EpisodeBuffer()
    moments.append(_observed(timestep.observation, envs.posture()))
    failures: dict[int, str] = {}
    for step in range(1, envs.steps + 1):
        hidden = envs.hidden()
        if agent.observes_plant:
            agent.observe_plant(hidden.get("plant"))
        action = agent.act(timestep.observation)
        timestep, failed = envs.step(action)
        agent.observe(timestep)
        moments.append(_observed(timestep.observation, envs.posture()))
        steps.append({"action": action, "reward": np.asarray(timestep.reward)} | hidden)
        for run, reason in failed.items():
            failures.setdefault(run, f"{reason} at step {step}")
        if len(failures) == envs.runs:
            break
    signals = agent.signals()
    trace = Trace(
        **moments.episode(),
        **steps.episode(),
        feedback=signals.feedback,
        learned=signals.learned,
        modules=signals.modules,
    )
    return Rollout(trace, failures)


def record_epoch(env: Environments, agent: Agent, epoch: int) -> Trace:
    """Run an episode and return its trace, as `rollout` does.

    Args:
        env: Environment that `mpma_mj.load` returned, or those that `mpma_mj.make_vec` returned.
        agent: Agent of as many runs.
        epoch: Number of the epoch, from 0.

    Raises:
        DivergedError: An episode ended before the demonstration.
    """
    recorded = rollout(env, agent, epoch)
    for reason in recorded.failures.values():
        raise DivergedError(f"epoch {epoch + 1}: {reason}", remedy=TRY_INSTEAD)
    return recorded.trace


# One run steps a dm_env environment: the vector environment is 1.3 to 2 times slower for a batch
# of one (measured, 50 to 200 nodes); results are the same to the bit.
class _Single:
    """The environment of one run; actions have shape (8,), postures (12,)."""

    def __init__(self, env: control.Environment) -> None:
        self._env = env
        self.runs, self.steps = 1, env.task.steps

    def reset(self, episode: int) -> dm_env.TimeStep:
        self._env.task.episode = episode
        return self._env.reset()

    def step(self, action: Array) -> tuple[dm_env.TimeStep, dict[int, str]]:
        """Act; return the timestep, and why the episode ended early, if it did."""
        timestep = self._env.step(action)
        failed = timestep.last() and timestep.discount == 0.0
        return timestep, {0: self._env.task.termination_reason} if failed else {}

    def posture(self) -> Array:
        return self._env.physics.posture()

    def hidden(self) -> dict[str, NDArray[np.intp]]:
        """Return what the next action meets and no observation contains, by name."""
        return _hidden(self._env.task)


class _Batch:
    """The environments of R runs; actions have shape (R, 8), postures (R, 12)."""

    def __init__(self, envs: VectorImitationEnv) -> None:
        self._envs, self._step = envs, 0
        self.runs, self.steps = envs.num_envs, envs.steps

    def reset(self, episode: int) -> dm_env.TimeStep:
        self._envs.episode[:] = episode
        observation, _ = self._envs.reset()
        return dm_env.restart(observation)

    def step(self, action: Array) -> tuple[dm_env.TimeStep, dict[int, str]]:
        """Act; return the timestep, and why episodes ended early, by run."""
        observation, reward, terminated, _, info = self._envs.step(action)
        self._step += 1
        last = self._step == self.steps
        kind = dm_env.StepType.LAST if last else dm_env.StepType.MID
        reasons = info["termination_reason"]
        failures = {run: reasons[run] for run in np.flatnonzero(terminated).tolist()}
        return dm_env.TimeStep(kind, reward, 1.0 - terminated, observation), failures

    def posture(self) -> Array:
        return self._envs.posture

    def hidden(self) -> dict[str, NDArray[np.intp]]:
        """Return what the next actions meet and no observation contains, by name."""
        return _hidden(self._envs)


def _hidden(envs: TwoArmImitation | VectorImitationEnv) -> dict[str, NDArray[np.intp]]:
    found = {"plant": envs.plant, "latency": envs.latency}
    return {name: np.asarray(now, np.intp) for name, now in found.items() if now is not None}


def _observed(observation: Observation, posture: Array) -> dict[str, Array]:
    """Return the signals of a moment, with the true posture, shape (..., 12), in place."""
    return {name: observation[name] for name in OBSERVED} | {"posture": posture}
