"""Motions of known joint angles, and their comparison."""

import dataclasses

import numpy as np
from scipy.ndimage import gaussian_filter1d

from mpma_mj import kinematics
from mpma_mj.context import equal_segments
from mpma_mj.motions import Motion
from mpma_mj.motions.feasibility import JointLimits

__all__ = ["LIMITS", "SPEED", "check_equal", "moving", "raising", "singular"]

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


def singular(seed: int, frames: int = 200, seconds: float = 0.3) -> Motion:
    """Return a cyclic motion whose arms keep passing straight forward and straight elbows."""
    rng = np.random.default_rng(seed)

    def smooth() -> np.ndarray:
        walk = gaussian_filter1d(rng.normal(size=(frames, 3)), 20.0 * seconds, axis=0, mode="wrap")
        return walk / walk.std()

    vectors = []
    for side in (1.0, -1.0):
        upper_arm = np.array([1.0, 0.3 * side, -0.3]) + 0.7 * smooth()
        upper_arm /= np.linalg.norm(upper_arm, axis=1, keepdims=True)
        forearm = upper_arm + 0.6 * smooth()
        vectors += [upper_arm, forearm / np.linalg.norm(forearm, axis=1, keepdims=True)]
    context, labels = equal_segments(frames, 2)
    return Motion(np.concatenate(vectors, axis=1), context, labels, 20.0, "singular", "a test")


def check_equal(found: Motion | None, expected: Motion) -> None:
    assert found is not None
    for field in dataclasses.fields(Motion):
        value, other = getattr(found, field.name), getattr(expected, field.name)
        if isinstance(other, np.ndarray):
            np.testing.assert_array_equal(value, other)
        else:
            assert value == other
            assert type(value) is type(other)
