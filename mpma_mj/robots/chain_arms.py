"""Kinematics of a pair of arms that are chains of four hinges with any axes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.arm_kinematics import ArmKinematics
from mpma_mj.kinematics import wrap
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.nearest_posture import nearest_posture

__all__ = ["ChainArms"]

Array = NDArray[np.float64]

_DAMPING = 0.01  # of a correction: directions that are harder to move count for less (choice)


class ChainArms(ArmKinematics):
    """Kinematics of a left and a right chain.

    Attributes:
        robot: Name of the robot.
        chains: Left and right arm.
    """

    def __init__(self, robot: str, left: Chain, right: Chain, values: Sequence[float] = ()) -> None:
        """Combine two chains.

        Args:
            robot: Name of the robot.
            left: Left arm.
            right: Right arm.
            values: Physical values, which distinguish robots of one name, too.
        """
        self.robot, self.chains = robot, (left, right)
        self.joint_names = left.joints + right.joints
        self._lowest = np.concatenate([left.lowest, right.lowest])
        self._highest = np.concatenate([left.highest, right.highest])
        self._free = np.concatenate([left.endless, right.endless])
        geometry = [
            np.concatenate([chain.axes.ravel(), chain.upper_arm, chain.forearm])
            for chain in self.chains
        ]
        numbers = np.concatenate([*geometry, self._lowest, self._highest, values]).round(9) + 0.0
        # A robot whose file or model was changed is another one.
        self.name = f"{robot} {hashlib.sha256(numbers.tobytes()).hexdigest()[:8]}"

    def posture(self, joint_angles: Array) -> Array:
        """Return the posture of joint angles."""
        left, right = self.chains
        return np.concatenate(
            [left.directions(joint_angles[..., :4]), right.directions(joint_angles[..., 4:])],
            axis=-1,
        )

    def angles(self, posture: Array, near: Array) -> Array:
        """Return the joint angles within the ranges that come nearest to a posture nearby."""
        near = np.broadcast_to(near, (*posture.shape[:-1], 8))
        found = [
            nearest_posture(
                chain, posture[..., 6 * arm : 6 * arm + 6], near[..., 4 * arm :][..., :4]
            )
            for arm, chain in enumerate(self.chains)
        ]
        return np.concatenate([angles for angles, _ in found], axis=-1)

    def step_to(self, joint_angles: Array, near: Array) -> Array:
        """Return the step to joint angles, less whole turns of joints without a range."""
        step = joint_angles - near
        return np.where(self._free, wrap(step), step)

    def correction(self, posture: Array, near: Array) -> Array:
        """Return one damped step of Gauss and Newton, within the joints' ranges.

        (JᵀJ + 0.01 I) Δq = Jᵀ (d* - d(q))
        """
        near = np.broadcast_to(near, (*posture.shape[:-1], 8))
        steps = []
        for arm, chain in enumerate(self.chains):
            shown, jacobian = chain.jacobian(near[..., 4 * arm : 4 * arm + 4])
            error = posture[..., 6 * arm : 6 * arm + 6] - shown
            transposed = np.swapaxes(jacobian, -1, -2)
            matrix = transposed @ jacobian + _DAMPING * np.eye(4)
            steps.append(np.linalg.solve(matrix, transposed @ error[..., None])[..., 0])
        reached = near + np.concatenate(steps, axis=-1)
        return np.clip(reached, self._lowest, self._highest) - near

    def continuation(self, joint_angles: Array, near: Array) -> tuple[Array, Array]:
        """Return whole turns of joints without a range."""
        offset = near + self.step_to(joint_angles, near) - joint_angles
        return np.ones(8), np.round(offset / (2.0 * np.pi)) * 2.0 * np.pi * self._free
