"""The CMU humanoid of dm_control, a robot that is always installed, and what it dances."""

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest

from mpma_mj import joint_paths, kinematics
from mpma_mj.envs.load import arm_limits
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.feasibility import JointLimits
from mpma_mj.motions.feasible_motion import fitted

__all__ = ["HUMANOID", "check_limits", "cut", "humanoid_limits", "short_dance", "without_two_arm"]

HUMANOID = "cmu_humanoid"


@functools.cache
def humanoid_limits() -> JointLimits:
    return arm_limits(EnvironmentOptions(robot=HUMANOID))


def check_limits(joint_angles: np.ndarray, rate: float) -> None:
    """Check that joint angles, shape (T, 8), rad, stay within the humanoid's ranges and speeds."""
    limits = humanoid_limits()
    assert (joint_angles >= limits.lowest).all()
    assert (joint_angles <= limits.highest).all()
    assert (np.abs(np.diff(joint_angles, axis=0)) * rate <= limits.max_speed).all()


def cut(motion: Motion, start: int, end: int) -> Motion:
    """Return the postures of a motion from one to before another."""
    part = slice(start, end)
    return dataclasses.replace(motion, posture=motion.posture[part], context=motion.context[part])


@functools.cache
def short_dance() -> Motion:
    """Return two seconds of YMCA with joint angles of the humanoid, which do not lead on."""
    return fitted(cut(ymca(), 10, 50), humanoid_limits())[0]


def without_two_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all kinematics of `two_arm` fail, under whatever name it was imported."""

    def fails(*_: Any, **__: Any) -> None:
        raise AssertionError("kinematics of two_arm for another robot")

    for function in (
        *(kinematics.posture_from_angles, kinematics.angles_from_posture, kinematics.nearest_step),
        *(joint_paths.held_angles, joint_paths.continuous_angles),
        *(joint_paths.nearest_turn, joint_paths.continuation),
    ):
        monkeypatch.setattr(function, "__code__", fails.__code__)
