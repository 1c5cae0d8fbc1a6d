"""Motions of known joint angles, and their comparison."""

import dataclasses

import numpy as np

from mpma_mj import kinematics
from mpma_mj.context import equal_segments
from mpma_mj.motions import Motion
from mpma_mj.motions.feasibility import JointLimits

__all__ = ["LIMITS", "SPEED", "check_equal", "moving", "raising"]

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)  # rad/s
LIMITS = JointLimits(
    SPEED,
    np.array([-np.inf, -np.inf, -np.inf, 0.0] * 2),
    np.array([np.inf, np.inf, np.inf, 2.8] * 2),
)  # of the package's arms


def moving(angles: np.ndarray, rate: float = 20.0) -> Motion:
    context, labels = equal_segments(len(angles), 2)
    return Motion(kinematics.posture_from_angles(angles), context, labels, rate, "moving", "a test")


def raising(speed: float, joint: int = 0, frames: int = 10) -> Motion:
    angles = np.tile([0.3, 0.1, 0.2, 0.5] * 2, (frames, 1))
    angles[:, joint] += np.arange(frames) * speed / 20.0
    return moving(angles)


def check_equal(found: Motion | None, expected: Motion) -> None:
    assert found is not None
    for field in dataclasses.fields(Motion):
        value, other = getattr(found, field.name), getattr(expected, field.name)
        if isinstance(other, np.ndarray):
            np.testing.assert_array_equal(value, other)
        else:
            assert value == other
            assert type(value) is type(other)
