"""Episodes of an agent that learns nothing, with moments to which they can go back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.base import Observation
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.agents.wrappers import Frozen, paired_models_of
from mpma_mj.context import active_label
from mpma_mj.envs.interventions import EnvironmentMoment, Intervention
from mpma_mj.errors import BadOptionError
from mpma_mj.metrics import posture_error_percent

__all__ = ["LiveEpisode", "Moment", "error_percent"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Moment:
    """Moment of an episode.

    Attributes:
        step: Step of the demonstration.
        posture: True posture of the arms, shape (12,).
        reference: Demonstrated posture, shape (12,).
        label: Label that is active; empty where none is.
        responsibility: Responsibilities of the modules in the action that led here, shape (M,);
            None at the beginning, and of an agent without modules.
        plant: Index of the plant that is on; None in an environment without plants.
        push: Forces on left and right hand that led here, shape (2, 3), N.
        environment: State of the environment.
    """

    step: int
    posture: Array
    reference: Array
    label: str
    responsibility: Array | None
    plant: int | None
    push: Array
    environment: EnvironmentMoment


@dataclass(frozen=True, eq=False)
class _Act:
    """What an agent received for an action."""

    observation: Observation
    plant: NDArray[np.intp] | None
    enabled: NDArray[np.bool_] | None


class LiveEpisode:
    """An environment and an agent, step by step.

    To go back, the environment gets the state of the moment, and the agent acts once more on the
    observations before it: that takes 0.1 ms a step, needs no more than the observations, and is
    the same to the bit for every agent, as episodes depend on the seed and their number alone.

    Attributes:
        env: Environment, which is adjustable.
        agent: Agent, which learns nothing.
        pairs: The agent with modules inside; None if it has none.
        episode: Number of the episode.
        moments: Moments of the episode so far.
        is_over: Whether the episode has ended.
    """

    def __init__(self, env: control.Environment, agent: Agent, episode: int) -> None:
        """Begin an episode, given its number."""
        self.env, self.agent = env, Frozen(agent)
        self.pairs = _pairs(agent)
        self._past = mujoco.MjData(env.physics.model.ptr)
        self.begin(episode)

    def begin(self, episode: int) -> None:
        """Begin an episode, given its number."""
        self.episode = self.env.task.episode = episode
        self.agent.reset(episode)
        self._observation: Observation = self.env.reset().observation
        self._acts: list[_Act] = []
        self.is_over = False
        self.moments = [self._moment(np.zeros((2, 3)))]

    def advance(self, push: Array | None = None) -> None:
        """Act once; after the end of an episode begin the next one.

        Args:
            push: Forces on left and right hand meanwhile, shape (2, 3), N; none if not given.
        """
        if self.is_over:
            self.begin(self.episode + 1)
            return
        task = self.env.task
        forces = np.zeros((2, 3)) if push is None else np.array(push)
        if push is not None or task.push is not None:
            task.push = forces
        plant = None if task.plant is None else np.asarray(task.plant, np.intp)
        self._acts.append(_Act(self._observation, plant, self.enabled_modules))
        timestep = self.env.step(self._act(self._acts[-1]))
        self._observation, self.is_over = timestep.observation, timestep.last()
        self.moments.append(self._moment(forces))

    def go_back(self, index: int) -> None:
        """Go back to a moment of this episode; what is set by hand stays.

        Args:
            index: Index among the moments.
        """
        del self.moments[index + 1 :]
        if index < len(self._acts):
            self._observation, self.is_over = self._acts[index].observation, False
        del self._acts[index:]
        self.moments[index].environment.restore(self.env)
        enabled = self.enabled_modules
        self.agent.reset(self.episode)
        for act in self._acts:
            if self.pairs is not None and act.enabled is not None:
                self.pairs.set_enabled_modules(act.enabled)
            self._act(act)
        if self.pairs is not None and enabled is not None:
            self.pairs.set_enabled_modules(enabled)

    @property
    def enabled_modules(self) -> NDArray[np.bool_] | None:
        """Which modules may control, shape (M,); None of an agent without modules."""
        return None if self.pairs is None else self.pairs.enabled_modules

    def data(self, index: int | None = None) -> mujoco.MjData:
        """Return the state of the arms at a moment, by its index; at the present if not given."""
        physics = self.env.physics
        if index is None or index >= len(self.moments):
            return physics.data.ptr
        self.moments[index].environment.pose(physics.model.ptr, self._past)
        return self._past

    def intervene(self, intervention: Intervention) -> None:
        """Set payload, gain, plant or latency by hand; see `TwoArmImitation.intervene`."""
        self.env.task.intervene(self.env.physics, intervention)

    def set_enabled_modules(self, enabled: Sequence[bool]) -> None:
        """Switch modules off or on; see `PairedModels.set_enabled_modules`.

        Raises:
            BadOptionError: There are not as many modules.
        """
        if self.pairs is None:
            raise BadOptionError(f"{type(self.agent.agent).__name__} has no modules to switch off")
        self.pairs.set_enabled_modules(enabled)

    def _act(self, act: _Act) -> Array:
        """Return the agent's action, shape (8,)."""
        if self.agent.observes_plant:
            self.agent.observe_plant(act.plant)
        return self.agent.act(act.observation)

    def _moment(self, push: Array) -> Moment:
        """Return the present moment, given the forces that led here."""
        task, pairs = self.env.task, self.pairs
        label = int(active_label(self._observation["context"][None])[0])
        return Moment(
            step=task.step,
            posture=self.env.physics.posture(),
            reference=task.reference.copy(),
            label="" if label < 0 else task.motion.labels[label],
            responsibility=None if pairs is None else pairs.responsibility,
            plant=task.plant,
            push=push,
            environment=EnvironmentMoment.of(self.env),
        )


def error_percent(moments: Sequence[Moment]) -> float:
    """Return p_e of moments, percent; NaN of none."""
    if not moments:
        return float("nan")
    postures = np.array([(moment.posture, moment.reference) for moment in moments])
    return posture_error_percent(postures[:, 0], postures[:, 1])


def _pairs(agent: Agent) -> PairedModels | None:
    """Return the agent with modules inside all wrappers; None if it has none."""
    try:
        return paired_models_of(agent)
    except BadOptionError:
        return None
