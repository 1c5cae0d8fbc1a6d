"""The demonstration's own joint velocities, unwatched."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Observation
from mpma_mj.agents.fixed import FixedAgent

__all__ = ["OpenLoop"]

Array = NDArray[np.float64]


class OpenLoop(FixedAgent):
    """Commands the joint velocities of the demonstration without looking at the arms.

        u = clip((q'_{t+1} - q̂_t) / (Δt · v_max), -1, 1)        q̂_{t+1} = q̂_t + Δt · v_max · u

    q' solves the inverse kinematics near q̂, where arms would be that obey to the letter; it
    starts at the first demonstrated posture. What one step is too short for is made up for in
    the next (choice). Of what the arms do instead it takes no notice.
    """

    def __init__(self, spec: AgentSpec) -> None:
        """Take what the arms can do.

        Args:
            spec: Where it acts.
        """
        self._farthest = spec.control_timestep * spec.max_joint_speed
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode, at the first posture that will be demonstrated."""
        self._angles: Array | None = None

    def act(self, observation: Observation) -> Array:
        """Return the action, shape (..., 8), in [-1, 1]."""
        angles = self._angles
        if angles is None:  # near 0, as the arms start
            still = np.zeros((*observation["reference"].shape[:-1], 8))
            angles = kinematics.angles_from_posture(observation["reference"], near=still)
        way = kinematics.angles_from_posture(observation["target"], near=angles) - angles
        action = np.clip(way / self._farthest, -1.0, 1.0)
        self._angles = angles + self._farthest * action
        return action
