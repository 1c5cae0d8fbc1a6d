"""Forward kinematics of an arm: a shoulder of three hinges and an elbow of one, with any axes.

With all quantities at zero joint angles, and E_i the rotation about axis i by joint angle i
(product of exponentials; Lynch & Park 2017, Modern Robotics, chapter 4), the directions of the
upper arm u and of the forearm f are

    u = E_1 E_2 E_3 u_0        f = E_1 E_2 E_3 E_4 f_0

exactly, whether or not the axes of the shoulder meet: the shoulder point lies on axis 3 and the
elbow point on axis 4, so that u_0 is fixed in the third link and f_0 in the fourth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.rotations import turned

__all__ = ["Chain"]

Array = NDArray[np.float64]

# Sine of an angle between two axes or directions below which they count as parallel: 6°, with
# which an arm reaches next to nothing (choice).
_PARALLEL = 0.1


@dataclass(frozen=True, eq=False)
class Chain:
    """Four hinges of one arm, in the torso frame (x forward, y left, z up), at zero joint angles.

    Attributes:
        axes: Axes from the shoulder outward, shape (4, 3), made unit vectors.
        upper_arm: Direction from shoulder to elbow, shape (3,), made a unit vector.
        forearm: Direction from elbow to wrist, shape (3,), made a unit vector.
        lowest: Lowest joint angles, shape (4,), rad, -inf where there is none.
        highest: Highest joint angles, shape (4,), rad, inf where there is none.
        joints: Names of the joints, for messages.

    Raises:
        BadOptionError: A direction is zero or not finite, neighbouring axes of the shoulder are
            parallel, the elbow cannot bend, or a range is empty or has one end only.
    """

    axes: Array
    upper_arm: Array
    forearm: Array
    lowest: Array
    highest: Array
    joints: tuple[str, ...] = ("joint 1", "joint 2", "joint 3", "joint 4")

    @property
    def endless(self) -> NDArray[np.bool_]:
        """Whether a joint has no range, so that it may turn on and on, shape (4,)."""
        return np.isinf(self.lowest)

    def __post_init__(self) -> None:
        """Copy the arrays, with directions of length 1, and check them."""
        for name, shape in (
            ("axes", (4, 3)),
            ("upper_arm", (3,)),
            ("forearm", (3,)),
            ("lowest", (4,)),
            ("highest", (4,)),
        ):
            value = np.array(getattr(self, name), float)
            if value.shape != shape:
                raise BadOptionError(f"{name} of a chain has shape {value.shape}, not {shape}")
            if value.shape[-1] == 3:
                length = np.linalg.norm(value, axis=-1, keepdims=True)
                if not (np.isfinite(length) & (length > 0.0)).all():
                    raise BadOptionError(f"{name} of a chain is zero or not finite")
                value = value / length
            object.__setattr__(self, name, value)
        self._check()

    def _check(self) -> None:
        for i in range(2):
            if _sine(self.axes[i], self.axes[i + 1]) < _PARALLEL:
                raise BadOptionError(
                    f"{self.joints[i]} and {self.joints[i + 1]} turn about parallel axes",
                    remedy="neighbouring joints of a shoulder have different axes",
                )
        for name, direction in (("upper arm", self.upper_arm), ("forearm", self.forearm)):
            if _sine(self.axes[3], direction) < _PARALLEL:
                raise BadOptionError(
                    f"{self.joints[3]} cannot bend the elbow, as the {name} points along its axis",
                    remedy="the fourth joint of an arm is its elbow",
                )
        for joint, low, high in zip(self.joints, self.lowest, self.highest, strict=True):
            if not low < high:
                raise BadOptionError(f"the range of {joint} is empty: {low:g} to {high:g} rad")
            if np.isinf(low) != np.isinf(high):
                raise BadOptionError(f"the range of {joint} has one end: {low:g} to {high:g} rad")

    def directions(self, joint_angles: Array) -> Array:
        """Return the directions u and f, shape (..., 6), at joint angles, shape (..., 4), rad."""
        moved = self._moved(joint_angles, axes=0)
        return np.moveaxis(moved, 2, 0).swapaxes(1, 2).reshape(*joint_angles.shape[:-1], 6)

    def jacobian(self, joint_angles: Array) -> tuple[Array, Array]:
        """Compute the directions and their derivatives.

            ∂d/∂q_i = axis_i × d        for a direction d that joint i turns

        Args:
            joint_angles: Joint angles, shape (..., 4), rad.

        Returns:
            Directions u and f, shape (..., 6), and their derivatives, shape (..., 6, 4).
        """
        moved = self._moved(joint_angles, axes=4)
        (a, b, c), (x, y, z) = moved[:, :2, None], moved[:, None, :1:-1]
        derivatives = np.stack([y * c - z * b, z * a - x * c, x * b - y * a])  # (3, 2, 4, N)
        derivatives[:, 0, 3] = 0.0  # the elbow does not move the upper arm
        shape = joint_angles.shape[:-1]
        return (
            np.moveaxis(moved[:, :2], 2, 0).swapaxes(1, 2).reshape(*shape, 6),
            derivatives.transpose(3, 1, 0, 2).reshape(*shape, 6, 4),
        )

    def _moved(self, joint_angles: Array, axes: int) -> Array:
        """Return u, f and so many of the axes 4, 3, 2 and 1, shape (3, 2 + axes, N).

        Each component is an array of its own, which numpy computes three times as fast.
        """
        angles = joint_angles.reshape(-1, 4).T
        cosine, sine = np.cos(angles), np.sin(angles)
        moved = np.empty((3, 2 + axes, angles.shape[1]))
        moved[:, 0], moved[:, 1] = self.upper_arm[:, None], self.forearm[:, None]
        moved[:, 2:] = self.axes[::-1][:axes].T[:, :, None]
        moved[:, 1] = turned(moved[:, 1], self.axes[3], cosine[3], sine[3])
        for i in (2, 1, 0):
            outward = np.s_[:, : min(5 - i, 2 + axes)]
            moved[outward] = turned(moved[outward], self.axes[i], cosine[i], sine[i])
        return moved


def _sine(one: Array, other: Array) -> float:
    return float(np.linalg.norm(np.cross(one, other)))
