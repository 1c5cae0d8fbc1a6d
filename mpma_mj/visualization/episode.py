"""Arms at each moment of an episode, for videos and for the window."""

from __future__ import annotations

import numpy as np

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace

__all__ = ["EpisodeArms", "ideal_trace"]


class EpisodeArms:
    """Arms that take the postures of an episode, without simulation.

    Attributes:
        physics: The arms, with the plant of the current step where the episode has several.
    """

    def __init__(self, trace: Trace, options: EnvironmentOptions | None = None) -> None:
        """Make the arms.

        Args:
            trace: Trace of the episode.
            options: Options of the environment, whose arms are shown; the defaults if None.

        Raises:
            BadOptionError: The environment's model cannot be read.
        """
        self.physics = PhysicsArms.make(options)
        self._joint_angles = trace.true_joint_angles()
        self._plant = trace.plant

    def pose(self, step: int) -> None:
        """Move the arms to where they were at a step, from 0 to T."""
        self.physics.set_joint_state(self._joint_angles[step], np.zeros(8))
        if self._plant is not None:
            self.physics.set_plant(int(self._plant[min(step, len(self._plant) - 1)]))


def ideal_trace(motion: Motion) -> Trace:
    """Return the trace of arms in exactly the demonstrated postures."""
    steps = len(motion) - 1
    return Trace(
        posture=motion.posture,
        reference=motion.posture,
        context=motion.context,
        joint_angles=motion.joint_angles,
        joint_velocities=np.zeros_like(motion.joint_angles),
        action=np.zeros((steps, 8)),
        reward=np.zeros(steps),
    )
