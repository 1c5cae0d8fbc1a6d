"""Agents that do not learn: flat lines."""

from __future__ import annotations

import numpy as np
from evaluation import Curve, Evaluation
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.agents import AGENTS as BUILT_IN
from mpma_mj.agents import Agent, AgentSpec
from mpma_mj.agents.base import Observation
from mpma_mj.kinematics import angles_from_posture
from mpma_mj.options import Arms

__all__ = ["AGENTS", "dance"]

Array = NDArray[np.float64]


class Anticipating(Agent):
    """The hand-written agent of docs/guides/own_agent.md."""

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (8,)."""
        angles = observation["joint_angles"]
        wanted = angles_from_posture(observation["target"], near=angles)
        farthest = self.spec.max_joint_speed * self.spec.control_timestep  # rad a step
        return np.clip((wanted - angles) / farthest, -1, 1)


AGENTS: dict[str, type[Agent]] = {
    "random": BUILT_IN["random"],
    "open loop": BUILT_IN["open_loop"],
    "feedback only": BUILT_IN["feedback_only"],
    "by hand": Anticipating,
}


def dance(name: str, seed: int, arms: Arms) -> Curve:
    """Measure one of `AGENTS` once, at 0 steps: it needs none."""
    env = mpma_mj.load("ymca", arms=arms)
    spec = AgentSpec(4, env.task.max_joint_speed, env.control_timestep())
    agent = AGENTS[name]
    yield 0, Evaluation(arms).p_e(agent(agent.config_type(), spec, seed=seed))
