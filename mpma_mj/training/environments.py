"""Environments of one run or of a batch of runs, behind one interface of two methods.

One run steps a dm_env environment, a batch the vector environment, which is 1.3 to 2 times slower
for a batch of one (measured, 50 to 200 nodes); results are the same to the bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import dm_env
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.envs.vector_env import VectorImitationEnv

__all__ = ["EnvironmentBatch", "Environments", "EpisodeInfo", "SingleEnvironment", "wrap"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EpisodeInfo:
    """Facts about episodes that metrics and agents need.

    Attributes:
        labels: Names of the context's labels.
        period: Steps from one repetition of the motion to the next.
        steps: Steps T of an episode.
        context: Context at each moment of an episode, shape (T + 1, C).
        rate: Steps per second, Hz.
        site_positions: Positions of shoulders, elbows and wrists in postures; see
            `PhysicsArms.site_positions`.
    """

    labels: tuple[str, ...]
    period: int
    steps: int
    context: Array
    rate: float
    site_positions: Callable[[Array], Array]


class Environments(Protocol):
    """Environments of one run, or of R runs that step together.

    Attributes:
        info: Facts about their episodes.
        shape: Shape of the batch: () for one run, (R,) for several.
    """

    info: EpisodeInfo
    shape: tuple[int, ...]

    def reset(self, episode: int) -> dm_env.TimeStep:
        """Begin an episode of every run, given its number from 0."""

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act, shape (…, 8); return reward, shape (…), and observation."""

    def posture(self) -> Array:
        """Return the true postures of the arms, shape (…, 12)."""

    def plant(self) -> NDArray[np.intp] | None:
        """Return which plant the next action meets, by index, shape (…); None without plants."""

    def failures(self) -> dict[int, str]:
        """Return why episodes ended early at the last step, by run; nothing where none did."""


class SingleEnvironment:
    """The environment of one run."""

    def __init__(self, env: control.Environment) -> None:
        """Wrap an environment that `mpma_mj.load` returned."""
        task = env.task
        self._env = env
        self._timestep: dm_env.TimeStep | None = None
        self.shape: tuple[int, ...] = ()
        self.info = EpisodeInfo(
            labels=task.motion.labels,
            period=task.period,
            steps=task.steps,
            context=task.context,
            rate=task.motion.rate,
            site_positions=env.physics.site_positions,
        )

    def reset(self, episode: int) -> dm_env.TimeStep:
        """Begin an episode, given its number from 0."""
        self._env.task.episode = episode
        return self._env.reset()

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act, shape (8,)."""
        self._timestep = self._env.step(action)
        return self._timestep

    def posture(self) -> Array:
        """Return the true posture of the arms, shape (12,)."""
        posture: Array = self._env.physics.posture()
        return posture

    def plant(self) -> NDArray[np.intp] | None:
        """Return which plant the next action meets, by index, shape (); None without plants."""
        plant = self._env.task.plant
        return None if plant is None else np.asarray(plant, np.intp)

    def failures(self) -> dict[int, str]:
        """Return why the episode ended early at the last step."""
        ended = self._timestep is not None and self._timestep.last()
        if not ended or self._timestep.discount != 0.0:  # type: ignore[union-attr] # not None
            return {}
        return {0: self._env.task.termination_reason}


class EnvironmentBatch:
    """The environments of R runs."""

    def __init__(self, envs: VectorImitationEnv) -> None:
        """Wrap environments that `mpma_mj.make_vec` returned."""
        self._envs = envs
        self._terminated: NDArray[np.bool_] = np.zeros(envs.num_envs, bool)
        self._step = 0
        self._reasons = np.full(envs.num_envs, "", object)
        self.shape: tuple[int, ...] = (envs.num_envs,)
        self.info = EpisodeInfo(
            labels=envs.motion.labels,
            period=envs.period,
            steps=envs.steps,
            context=envs.context,
            rate=envs.motion.rate,
            site_positions=envs.arms.site_positions,
        )

    def reset(self, episode: int) -> dm_env.TimeStep:
        """Begin an episode of every run, given its number from 0."""
        self._envs.episode[:] = episode
        self._step = 0
        observation, _ = self._envs.reset()
        return dm_env.restart(observation)

    def step(self, action: Array) -> dm_env.TimeStep:
        """Act, shape (R, 8)."""
        observation, reward, terminated, _, info = self._envs.step(action)
        self._terminated = np.asarray(terminated)
        self._reasons = info["termination_reason"]
        self._step += 1
        last = self._step == self.info.steps
        kind = dm_env.StepType.LAST if last else dm_env.StepType.MID
        return dm_env.TimeStep(kind, reward, 1.0 - self._terminated, observation)

    def posture(self) -> Array:
        """Return the true postures of the arms, shape (R, 12)."""
        return self._envs.posture

    def plant(self) -> NDArray[np.intp] | None:
        """Return which plant the next action meets, by index, shape (R,); None without plants."""
        return self._envs.plant

    def failures(self) -> dict[int, str]:
        """Return why episodes ended early at the last step, by run."""
        return {run: self._reasons[run] for run in np.flatnonzero(self._terminated).tolist()}


def wrap(env: control.Environment | VectorImitationEnv | Environments) -> Environments:
    """Return the interface of two methods to what `load` or `make_vec` returned."""
    if isinstance(env, VectorImitationEnv):
        return EnvironmentBatch(env)
    if isinstance(env, SingleEnvironment | EnvironmentBatch):
        return env
    return SingleEnvironment(env)
