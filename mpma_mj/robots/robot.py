"""Robots: a model, the four joints of each arm, and the physical values of these joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES

__all__ = ["FASTEST", "QUANTITIES", "UNKNOWN", "JointValues", "Robot"]

Array = NDArray[np.float64]

QUANTITIES = {
    "speed": "rad/s",
    "force": "N m",
    "armature": "kg m²",
    "damping": "N m s/rad",
    "kv": "N m s/rad",
}
"""Physical values of joints, with their units."""

FASTEST = 100.0
"""Top speed of joints up to which a number can be one, rad/s."""

UNKNOWN = "unknown"
"""Source of values that no document gives."""


@dataclass(frozen=True)
class JointValues:
    """A physical value of the joints of an arm, the same on both sides.

    Attributes:
        values: Four numbers, from the shoulder outward; None where they are unknown.
        source: Document that gives them, or `UNKNOWN`.
    """

    values: tuple[float, ...] | None = None
    source: str = UNKNOWN


@dataclass(frozen=True)
class Robot:
    """Content of a robot file, with the path of its model.

    Attributes:
        name: Name, as options and file names contain it.
        title: Name for people.
        licence: Licence and owner of the model.
        path: The robot file; that of the model where there is no other.
        model: MJCF or URDF file.
        joints: Names of the eight joints, the left arm's first, each from the shoulder outward.
        up: Direction in the model's frame that is up for the torso; forward follows from the
            shoulders.
        wrists: Joints at the ends of the left and the right forearm; None where it ends with the
            vertices that are farthest from the elbow.
        rest: Angles, rad, or displacements, m, of joints that do not move; 0 where not given.
        ranges: Lowest and highest angle, rad, of joints of which the model has a wrong range.
        physical: Values of the joints by their quantity, one of `QUANTITIES`.
        complete: Whether the model has the joints, sites and actuators of `two_arm.xml`, and is
            used as it is.
    """

    name: str
    title: str
    licence: str
    path: Path
    model: Path
    joints: tuple[str, ...] = JOINT_NAMES
    up: tuple[float, ...] = (0.0, 0.0, 1.0)
    wrists: tuple[str, ...] | None = None
    rest: Mapping[str, float] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    physical: Mapping[str, JointValues] = field(default_factory=dict)
    complete: bool = False

    @property
    def unknown(self) -> list[str]:
        """Physical values that the file does not know, without which arms are ideal ones only."""
        known = (name for name, one in self.physical.items() if one.values is not None)
        return [] if self.complete else sorted(set(QUANTITIES).difference(known))

    @property
    def numbers(self) -> list[float]:
        """All physical values in one order, -1 for those that are unknown."""
        known = (self.physical.get(quantity, JointValues()).values for quantity in QUANTITIES)
        return [value for values in known for value in values or (-1.0,)]

    def values(self, quantity: str, otherwise: float | None = None) -> Array:
        """Return a physical value of each joint, shape (8,), in its unit.

        Args:
            quantity: One of `QUANTITIES`.
            otherwise: Value where it is unknown; None for one that has to be known.

        Raises:
            BadOptionError: It is unknown.
        """
        known = self.physical.get(quantity, JointValues()).values
        if known is None and otherwise is not None:
            return np.full(8, otherwise)
        if known is None:
            ideal = "" if quantity == "speed" else "choose {arms=kinematic}, or "
            mend = f"give [{quantity}] with values = [four, from the shoulder outward] and source"
            raise BadOptionError(
                f"{self.path}: {quantity} of the joints, {QUANTITIES[quantity]}, is unknown",
                remedy=f"{ideal}{mend}",
            )
        return np.tile(known, 2)
