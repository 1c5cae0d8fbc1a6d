"""Agents that learn nothing: random actions, the open loop, and two closed-form controllers."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent, AgentSignals, AgentSpec, Observation, Seeds
from mpma_mj.agents.config import (
    JOINTS,
    AgentConfig,
    FeedbackOnlyConfig,
    OpenLoopConfig,
    RandomConfig,
    ResolvedRateConfig,
)
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.agents.gain_schedule import FINAL_GAINS
from mpma_mj.feedback import followed
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.seeding import stream

__all__ = ["FeedbackOnly", "OpenLoop", "RandomAgent", "ResolvedRate"]

Array = NDArray[np.float64]


class RandomAgent(Agent):
    """Random actions, uniform in [-1, 1]."""

    config_type: ClassVar[type[AgentConfig]] = RandomConfig

    def __init__(self, config: RandomConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Begin with episode 0; arguments as of `Agent`."""
        super().__init__(config, spec, seed=seed)
        self._shape = (*np.shape(seed), JOINTS)
        self._seeds: list[int] = np.ravel(seed).tolist()
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with that episode's random numbers."""
        self._streams = [stream(seed, "random_action", episode) for seed in self._seeds]

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._seeds = [self._seeds[i] for i in runs]
        self._shape = (*runs.shape, JOINTS)

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        drawn = [rng.uniform(-1.0, 1.0, JOINTS) for rng in self._streams]
        return np.reshape(drawn, self._shape)


class OpenLoop(Agent):
    """Joint velocities of the demonstration, without a look at the arms.

        u = clip((q'_{t+1} - q̂_t) / (Δt · v_max), -1, 1)        q̂_{t+1} = q̂_t + Δt · v_max · u

    q' solves the inverse kinematics near q̂, the joint angles of arms that follow exactly; q̂
    starts at the first demonstrated posture. The part of a step that is beyond the largest
    velocity is added to the next (choice).
    """

    config_type: ClassVar[type[AgentConfig]] = OpenLoopConfig

    _angles: Array | None = None  # q̂, shape (..., 8)

    def reset(self, episode: int) -> None:
        """Begin an episode at its first demonstrated posture."""
        self._angles = None

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        angles, target = self._angles, followed(observation, "target")
        if angles is None:  # near 0, as the arms start
            still = np.zeros((*target.shape[:-1], JOINTS))
            angles = still + self._way(still, followed(observation, "reference"))
        way = self._way(angles, target)
        farthest = self.spec.largest_move
        action = np.clip(way / farthest, -1.0, 1.0)
        self._angles = angles + farthest * action
        return action

    def _way(self, angles: Array, target: Array) -> Array:
        """Return the way from joint angles, shape (..., 8), rad, to a posture or joint angles."""
        if target.shape[-1] == JOINTS:
            return self.spec.kinematics.step_to(target, near=angles)
        return self.spec.kinematics.angles(target, near=angles) - angles


class FeedbackOnly(Agent):
    """The feedback controller without models: u = u_fb, that is K = 1 and L = 0.

    It corrects the present error, so that it follows one step behind the demonstration.
    """

    config_type: ClassVar[type[AgentConfig]] = FeedbackOnlyConfig

    def __init__(self, config: AgentConfig, spec: AgentSpec, *, seed: Seeds = 0) -> None:
        """Begin without a step; arguments as of `Agent`."""
        super().__init__(config, spec, seed=seed)
        self._steps = EpisodeBuffer()

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self._steps.clear()

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R."""
        self._steps = EpisodeBuffer()

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        reference = followed(observation, "reference")
        action = self.spec.feedback(observation["joint_angles"], reference)
        self._steps.append({"feedback": action})
        return action

    def signals(self) -> AgentSignals:
        """Return the action as `feedback`; none before the first step."""
        if not len(self._steps):
            return AgentSignals()
        return AgentSignals(feedback=self._steps.episode()["feedback"].copy())


class ResolvedRate(FeedbackOnly):
    """The resolved-rate command and feedback without models: u = clip(m + K u_fb).

        m_t = u_fb(q_t, x'_{t+1})        K = 0.14

    It is what joint models add to, with the gain of the feedback after their first epoch: what
    MPMA would do if it had learned nothing (Whitney 1969).
    """

    config_type: ClassVar[type[AgentConfig]] = ResolvedRateConfig

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        angles = observation["joint_angles"]
        reference, target = followed(observation, "reference"), followed(observation, "target")
        feedback = FINAL_GAINS.feedback * self.spec.feedback(angles, reference)
        self._steps.append({"feedback": feedback})
        return clip(self.spec.feedback(angles, target) + feedback)
