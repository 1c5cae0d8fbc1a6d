"""Arms at each moment of an episode, for videos and for the window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.load import check_same_robot
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.options import TWO_ARM
from mpma_mj.trace import Trace

__all__ = ["EpisodeArms"]

Array = NDArray[np.float64]


class EpisodeArms:
    """Arms that take the postures of an episode, without simulation.

    Attributes:
        physics: The arms, with the plant of the current step where the episode has several.
    """

    def __init__(
        self,
        trace: Trace,
        options: EnvironmentOptions | None = None,
        robot: str = TWO_ARM,
    ) -> None:
        """Make the arms.

        Args:
            trace: Trace of the episode.
            options: Options of the environment, whose arms are shown; the defaults if None.
            robot: Name of the kinematics of the arms that moved so; see `Motion.angles_of`.

        Raises:
            BadOptionError: The environment's model cannot be read, or the robot has changed.
        """
        self.physics = PhysicsArms.make(options)
        check_same_robot(robot, self.physics.kinematics.name)
        self._joint_angles = trace.true_joint_angles(self.physics.kinematics)
        self._reference = trace.reference
        self._plant = trace.plant

    def pose(self, moment: float) -> Array:
        """Move the arms to where they were, and return the demonstrated posture, shape (12,).

        Args:
            moment: The moment in control steps, from 0 to T; between two, joint angles and
                demonstration are interpolated.
        """
        self.physics.set_joint_state(_between(self._joint_angles, moment), np.zeros(8))
        if self._plant is not None:
            self.physics.set_plant(int(self._plant[min(int(moment), len(self._plant) - 1)]))
        reference = _between(self._reference, moment)
        if moment == int(moment):
            return reference
        vectors = reference.reshape(4, 3)
        lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
        return (vectors / np.maximum(lengths, 1e-9)).ravel()  # 0 between opposite ones


def _between(rows: Array, moment: float) -> Array:
    """Return the row of a moment, shape (D,), linearly interpolated between two."""
    step = int(moment)
    share = moment - step
    return rows[step] if share == 0.0 else (1.0 - share) * rows[step] + share * rows[step + 1]
