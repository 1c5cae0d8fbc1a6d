"""Kinematics of a pair of arms as agents and environments use it, whatever the robot."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.options import TWO_ARM

__all__ = ["TWO_ARMS", "ArmKinematics", "TwoArms"]

Array = NDArray[np.float64]


class ArmKinematics(ABC):
    """Relation between eight joint angles and the posture of two arms.

    Attributes:
        name: Name by which a motion states whose joint angles it has.
        joint_names: Names of the joints, those of the left arm first, from the shoulder outward.
    """

    name: str
    joint_names: tuple[str, ...]

    def __eq__(self, other: object) -> bool:
        """Return whether joint angles mean the same for others."""
        return isinstance(other, ArmKinematics) and self.name == other.name

    def __hash__(self) -> int:
        """Return the hash of the name."""
        return hash(self.name)

    @abstractmethod
    def posture(self, joint_angles: Array) -> Array:
        """Return the posture, shape (..., 12), of joint angles, shape (..., 8), rad."""

    @abstractmethod
    def angles(self, posture: Array, near: Array) -> Array:
        """Return joint angles that hold a posture, or come closest to it nearby.

        Args:
            posture: Posture, shape (..., 12).
            near: Joint angles that the solution is near to, shape (..., 8), rad.

        Returns:
            Joint angles, shape (..., 8), rad.
        """

    @abstractmethod
    def step_to(self, joint_angles: Array, near: Array) -> Array:
        """Return the smallest step to joint angles, or to others that hold the same posture.

        Args:
            joint_angles: Joint angles, shape (..., 8), rad.
            near: Joint angles from which the step goes, shape (..., 8), rad.

        Returns:
            The step, shape (..., 8), rad.
        """

    @abstractmethod
    def correction(self, posture: Array, near: Array) -> Array:
        """Return the step toward a posture, in which no angle is large that hardly moves the arm.

        Args:
            posture: Posture, shape (..., 12), which may have noise.
            near: Joint angles from which the step goes, shape (..., 8), rad.

        Returns:
            The step, shape (..., 8), rad.
        """

    @abstractmethod
    def continuation(self, joint_angles: Array, near: Array) -> tuple[Array, Array]:
        """Return how joint angles become those of the same posture that are nearest to others.

        Args:
            joint_angles: Joint angles q, shape (8,), rad.
            near: Joint angles to which they should be near, shape (8,), rad.

        Returns:
            Sign and offset, each shape (8,), of sign · q + offset.
        """


class TwoArms(ArmKinematics):
    """Kinematics of `two_arm`, in closed form; see `kinematics` and `joint_paths`."""

    name = TWO_ARM
    joint_names = kinematics.JOINT_NAMES

    def posture(self, joint_angles: Array) -> Array:
        """Return the posture of joint angles."""
        return kinematics.posture_from_angles(joint_angles)

    def angles(self, posture: Array, near: Array) -> Array:
        """Return the joint angles on the nearest branch."""
        return kinematics.angles_from_posture(posture, near=near)

    def step_to(self, joint_angles: Array, near: Array) -> Array:
        """Return the smallest step, by whole turns and to the other branch."""
        return joint_paths.nearest_turn(joint_angles, near=near)

    def correction(self, posture: Array, near: Array) -> Array:
        """Return the step to the nearest branch, weighted where it is nearly undefined.

        Abduction is weighted by cos²(flexion), rotation by sin(elbow) (choice).
        """
        step, cos_b, sin_e = kinematics.nearest_step(posture, near)
        step[0] *= cos_b**2
        step[2] *= sin_e
        return step.T.reshape(*posture.shape[:-1], 8)

    def continuation(self, joint_angles: Array, near: Array) -> tuple[Array, Array]:
        """Return whole turns, and the other branch where that is nearer."""
        return joint_paths.continuation(joint_angles, near=near)


TWO_ARMS = TwoArms()
