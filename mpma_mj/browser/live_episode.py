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
from mpma_mj.envs.interventions import Intervention
from mpma_mj.envs.moment import EnvironmentMoment
from mpma_mj.envs.physics import KinematicArms
from mpma_mj.envs.randomisation import PlantValues
from mpma_mj.errors import BadOptionError
from mpma_mj.metrics import posture_error_percent

__all__ = ["LARGEST_FORCE", "LiveEpisode", "Moment", "error_percent", "spring_force"]

Array = NDArray[np.float64]

LARGEST_FORCE = 80.0
"""Largest force on a hand that is dragged, N (choice)."""
_STIFFNESS = 400.0  # of the spring between hand and pointer, N/m (choice)


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
        plant_values: Its payload and other values, with those that are set by hand.
        push: Forces on left and right hand that led here, shape (2, 3), N.
        summed_error: Sum of the posture errors of the steps so far, percent.
        environment: State of the environment.
    """

    step: int
    posture: Array
    reference: Array
    label: str
    responsibility: Array | None
    plant: int | None
    plant_values: PlantValues
    push: Array
    summed_error: float
    environment: EnvironmentMoment


@dataclass(frozen=True, eq=False)
class _Act:
    """Input of an agent for an action: observation, plant, and enabled modules."""

    observation: Observation
    plant: NDArray[np.intp] | None
    enabled: NDArray[np.bool_] | None


class LiveEpisode:
    """Episode of an environment and an agent, step by step.

    To go back, the environment gets the state of the moment, and the agent acts once more on the
    observations before it: that takes 0.1 ms a step, needs no more than the observations, and is
    the same to the bit for every agent, as episodes depend on the seed and their number alone.

    Attributes:
        env: Environment, which is adjustable.
        agent: Agent, which learns nothing.
        paired_models: The agent with modules inside; None if it has none.
        number: Number of the episode.
        moments: Moments of the episode so far.
        is_over: Whether the episode has ended.
        failure: Why it ended before the demonstration; empty if it did not.
    """

    def __init__(self, env: control.Environment, agent: Agent, number: int) -> None:
        """Begin an episode, given its number."""
        self.env, self.agent = env, Frozen(agent)
        self.paired_models = _paired_models(agent)
        self._past = mujoco.MjData(env.physics.model.ptr)
        self.begin(number)

    def begin(self, number: int) -> None:
        """Begin an episode, given its number."""
        self.number = self.env.task.episode = number
        self.agent.reset(number)
        self._observation: Observation = self.env.reset().observation
        self._acts: list[_Act] = []
        self.is_over, self.failure = False, ""
        self.moments: list[Moment] = []
        self.moments.append(self._moment(np.zeros((2, 3))))

    def advance(self, push: Array | None = None) -> None:
        """Act once; after the end of an episode begin the next one.

        Args:
            push: Forces on left and right hand meanwhile, shape (2, 3), N; none if not given.
        """
        if self.is_over:
            self.begin(self.number + 1)
            return
        task = self.env.task
        forces = np.zeros((2, 3)) if push is None else np.array(push)
        if push is not None or task.push is not None:
            task.push = forces
        plant = None if task.plant is None else np.asarray(task.plant, np.intp)
        self._acts.append(_Act(self._observation, plant, self.enabled_modules))
        timestep = self.env.step(self._act(self._acts[-1]))
        self._observation, self.is_over = timestep.observation, timestep.last()
        self.failure = task.termination_reason if timestep.discount == 0.0 else ""
        self.moments.append(self._moment(forces))

    def go_back(self, index: int) -> None:
        """Go back to a moment of this episode; what is set by hand stays.

        Args:
            index: Index among the moments.
        """
        del self.moments[index + 1 :]
        if index < len(self._acts):
            self._observation = self._acts[index].observation
            self.is_over, self.failure = False, ""
        del self._acts[index:]
        self.moments[index].environment.restore(self.env)
        enabled = self.enabled_modules
        self.agent.reset(self.number)
        for act in self._acts:
            if self.paired_models is not None and act.enabled is not None:
                self.paired_models.set_enabled_modules(act.enabled)
            self._act(act)
        if self.paired_models is not None and enabled is not None:
            self.paired_models.set_enabled_modules(enabled)

    @property
    def enabled_modules(self) -> NDArray[np.bool_] | None:
        """Which modules may control, shape (M,); None of an agent without modules."""
        return None if self.paired_models is None else self.paired_models.enabled_modules

    def data(self, index: int | None = None) -> mujoco.MjData:
        """Return the state of the arms at a moment, by its index; at the present if not given."""
        physics = self.env.physics
        if index is None or index >= len(self.moments):
            return physics.data.ptr
        self.moments[index].environment.pose(physics.model.ptr, self._past)
        return self._past

    def model(self, index: int | None = None) -> mujoco.MjModel:
        """Return the model of the arms at a moment, with its payload; see `data`."""
        physics = self.env.physics
        if index is None or index >= len(self.moments) or isinstance(physics, KinematicArms):
            return physics.model.ptr
        return physics.compiled_plants.compiler.compile(self.moments[index].plant_values)

    def hand_positions(self, index: int | None = None) -> Array | None:
        """Return the positions of left and right hand at a moment, shape (2, 3), m; see `data`.

        None where they cannot be pushed: of ideal arms, and of models without hands.
        """
        physics = self.env.physics
        if isinstance(physics, KinematicArms) or not physics.compiled_plants.compiler.has_balls:
            return None
        positions: Array = self.data(index).xipos[physics.hand_ids].copy()
        return positions

    def pull(self, hand: int, pointer: Array) -> Array | None:
        """Return forces that pull a hand towards a pointer, shape (2, 3), N; see `spring_force`.

        None where hands cannot be pushed.

        Args:
            hand: 0 for the left hand, 1 for the right.
            pointer: Position of the pointer, shape (3,), m.
        """
        positions = self.hand_positions()
        if positions is None:
            return None
        forces = np.zeros((2, 3))
        forces[hand] = spring_force(positions[hand], pointer)
        return forces

    def intervene(self, intervention: Intervention) -> None:
        """Set payload, gain, plant or latency by hand; see `TwoArmImitation.intervene`."""
        self.env.task.intervene(self.env.physics, intervention)

    def set_enabled_modules(self, enabled: Sequence[bool]) -> None:
        """Switch modules off or on; see `PairedModels.set_enabled_modules`.

        Raises:
            BadOptionError: There are not as many modules.
        """
        if self.paired_models is None:
            raise BadOptionError(f"{type(self.agent.agent).__name__} has no modules to switch off")
        self.paired_models.set_enabled_modules(enabled)

    def _act(self, act: _Act) -> Array:
        """Return the agent's action, shape (8,)."""
        if self.agent.observes_plant:
            self.agent.observe_plant(act.plant)
        return self.agent.act(act.observation)

    def _moment(self, push: Array) -> Moment:
        """Return the present moment, given the forces that led here."""
        task, paired_models = self.env.task, self.paired_models
        label = int(active_label(self._observation["context"][None])[0])
        posture, reference = self.env.physics.posture(), task.reference.copy()
        summed_error = 0.0
        if self.moments:
            error = posture_error_percent(posture, reference)
            summed_error = self.moments[-1].summed_error + error
        return Moment(
            step=task.step,
            posture=posture,
            reference=reference,
            label="" if label < 0 else task.motion.labels[label],
            responsibility=None if paired_models is None else paired_models.responsibility,
            plant=task.plant,
            plant_values=self.env.physics.compiled_plants.values,
            push=push,
            summed_error=summed_error,
            environment=EnvironmentMoment.of(self.env),
        )


def spring_force(hand: Array, pointer: Array) -> Array:
    """Return the force on a hand that is dragged, shape (3,), N: of a spring, 80 N at most.

    Args:
        hand: Position of the hand, shape (3,), m.
        pointer: Position of the pointer, shape (3,), m.
    """
    force = _STIFFNESS * (pointer - hand)
    return force * min(1.0, LARGEST_FORCE / max(float(np.linalg.norm(force)), 1e-9))


def error_percent(moments: Sequence[Moment], first: int, last: int) -> float:
    """Return p_e of the steps from a moment to another, by their indices, percent.

    NaN where there is no step; the first may be before the beginning.
    """
    first = max(first, 0)
    if first >= last:
        return float("nan")
    return (moments[last].summed_error - moments[first].summed_error) / (last - first)


def _paired_models(agent: Agent) -> PairedModels | None:
    """Return the agent with modules inside all wrappers; None if it has none."""
    try:
        return paired_models_of(agent)
    except BadOptionError:
        return None
