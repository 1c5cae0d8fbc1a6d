"""What an agent has to know of where it acts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.feedback import feedback_action

__all__ = ["AgentSpec"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AgentSpec:
    """What an agent has to know of where it acts.

    Attributes:
        context_size: Size of the observation's context, C.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.
    """

    context_size: int
    max_joint_speed: Array
    control_timestep: float

    def feedback(self, joint_angles: Array, reference: Array) -> Array:
        """Return the feedback controller's action, u_fb, before its gain; see `feedback_action`.

        Args:
            joint_angles: Joint angles, shape (..., 8), rad.
            reference: Demonstrated posture, shape (..., 12).
        """
        return feedback_action(joint_angles, reference, self.max_joint_speed, self.control_timestep)
