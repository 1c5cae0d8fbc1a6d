"""Agents that do not learn: flat lines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from evaluation import Curve, Evaluation
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.agents import AgentSpec, FeedbackOnly, FixedAgent, OpenLoop, RandomAgent
from mpma_mj.agents.base import Observation
from mpma_mj.kinematics import angles_from_posture
from mpma_mj.options import Arms

__all__ = ["AGENTS", "dance"]

Array = NDArray[np.float64]


class Anticipating(FixedAgent):
    """The hand-written agent of docs/your_own_agent.md."""

    def __init__(self, *, max_joint_speed: Array, control_timestep: float) -> None:
        """Take what the arms can do: top speeds, shape (8,), rad/s, and the time of a step, s."""
        self._farthest = max_joint_speed * control_timestep

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (8,)."""
        angles = observation["joint_angles"]
        wanted = angles_from_posture(observation["target"], near=angles)
        return np.clip((wanted - angles) / self._farthest, -1, 1)


AGENTS: dict[str, Callable[[dict[str, Any], int], FixedAgent]] = {
    "random": lambda limits, seed: RandomAgent(seed=seed),
    "open loop": lambda limits, seed: OpenLoop(AgentSpec(4, **limits)),
    "feedback only": lambda limits, seed: FeedbackOnly(AgentSpec(4, **limits)),
    "by hand": lambda limits, seed: Anticipating(**limits),
}


def dance(name: str, seed: int, arms: Arms) -> Curve:
    """Measure one of `AGENTS` once, at 0 steps: it needs none."""
    env = mpma_mj.load("ymca", arms=arms)
    limits = {
        "max_joint_speed": env.task.max_joint_speed,
        "control_timestep": env.control_timestep(),
    }
    yield 0, Evaluation(arms).p_e(AGENTS[name](limits, seed))
