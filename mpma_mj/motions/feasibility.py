"""Feasibility: the joint angles and speeds that a motion demands, and those that arms can do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.motions.motion import Motion

__all__ = [
    "CHANGED",
    "JointLimits",
    "beyond_limits",
    "demand_lines",
    "joint_speeds",
    "near_singularity",
    "turned",
]

Array = NDArray[np.float64]

# Leverage of a joint over its segment below which a pose counts as near a singularity: within
# 15° of straight forward or back, or an elbow straighter than that (choice).
_LITTLE = np.sin(np.radians(15.0))

CHANGED = 1.0
"""Degrees from which a segment counts as changed (choice)."""


class JointLimits(NamedTuple):
    """Limits of the joints of two arms.

    Attributes:
        max_speed: Top speeds, shape (8,), rad/s.
        lowest: Lowest angles, shape (8,), rad, -inf where there is none.
        highest: Highest angles, shape (8,), rad, inf where there is none.
        kinematics: Kinematics of the arms.
    """

    max_speed: Array
    lowest: Array
    highest: Array
    kinematics: ArmKinematics = TWO_ARMS


def joint_speeds(motion: Motion) -> Array:
    """Return the speed that a motion demands of each joint, shape (T-1, 8), rad/s."""
    return np.abs(np.diff(motion.joint_angles, axis=0)) * motion.rate


def beyond_limits(motion: Motion, limits: JointLimits) -> str:
    """Describe where a motion demands what arms cannot do, by joint, time and value.

    Args:
        motion: The motion.
        limits: Limits of the arms.

    Returns:
        What a joint would have to do: to leave its range, to turn too fast, or to turn by an angle
        that the posture does not show. Empty where the arms can follow the motion.
    """
    angles, names = motion.joint_angles, limits.kinematics.joint_names
    beyond = np.maximum(limits.lowest - angles, angles - limits.highest)
    step, joint = _largest(beyond)
    if beyond[step, joint] > 0.0:
        return (
            f"{names[joint]} would have to be at {angles[step, joint]:.2f} rad"
            f" at {motion.time(step):.2f} s, but its range is {limits.lowest[joint]:g} to"
            f" {limits.highest[joint]:g}"
        )
    speeds = joint_speeds(motion)
    step, joint = _largest(speeds / limits.max_speed)
    if speeds[step, joint] > limits.max_speed[joint]:
        return (
            f"{names[joint]} would have to turn at {speeds[step, joint]:.1f} rad/s"
            f" at {motion.time(step):.2f} s, but its actuator reaches {limits.max_speed[joint]:g}"
        )
    if motion.feasible_angles is not None:
        return ""
    hidden = ~joint_paths.angles_seen(kinematics.angles_from_posture(motion.posture))
    step, joint = _largest(hidden)
    if hidden[step, joint]:
        return f"the angle of {names[joint]} cannot be seen at {motion.time(step):.2f} s"
    return ""


def _largest(values: NDArray[np.float64] | NDArray[np.bool_]) -> tuple[int, int]:
    """Return step and joint of the largest value, the first of several, of an array (T, 8)."""
    step, joint = divmod(int(np.argmax(values)), values.shape[1])
    return step, joint


def demand_lines(motion: Motion, limits: JointLimits) -> list[str]:
    """Describe what a motion demands of the joints, in lines of text.

    Args:
        motion: The motion.
        limits: Limits of the arms.
    """
    names = limits.kinematics.joint_names
    width = max(25, *map(len, names))
    lines = [f"{'joints:':<{width + 4}}range, rad      top speed of its limit, rad/s"]
    angles = motion.joint_angles
    fastest = joint_speeds(motion).max(axis=0)
    for joint, name in enumerate(names):
        low, high = angles[:, joint].min(), angles[:, joint].max()
        lines.append(
            f"  {name:<{width}} {low:6.2f} to {high:5.2f}   {fastest[joint]:6.1f} of"
            f" {limits.max_speed[joint]:g}"
        )
    if limits.kinematics == TWO_ARMS:  # others are singular elsewhere
        forward, straight = near_singularity(angles)
        lines.append(
            f"near a singularity: an upper arm points straight forward or back"
            f" {100 * forward:.0f} % of the time, an elbow is straight {100 * straight:.0f} %"
        )
    changed = float(np.mean(turned(motion, limits.kinematics).max(axis=1) > CHANGED))
    lines.append(
        f"the arms follow the closest motion that they can, with {100 * changed:.1f} % of the steps"
        f" changed by more than {CHANGED:g}°"
        if changed
        else "the arms can follow it"
    )
    return lines


def turned(motion: Motion, arms: ArmKinematics = TWO_ARMS) -> Array:
    """Return by how much each segment is turned in a feasible motion, shape (T, 4), degrees.

    Args:
        motion: The motion.
        arms: Kinematics of the arms whose joint angles it has.
    """
    if motion.feasible_angles is None:
        return np.zeros((len(motion), 4))
    shown = arms.posture(motion.feasible_angles)
    cosines = np.vecdot(shown.reshape(-1, 4, 3), motion.posture.reshape(-1, 4, 3))
    return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))


def near_singularity(joint_angles: Array) -> tuple[float, float]:
    """Return the shares of the time in which arms are near their two singularities.

    Args:
        joint_angles: Joint angles, shape (T, 8), rad.

    Returns:
        Share in which an upper arm points within 15° of straight forward or back, and share in
        which an elbow is within 15° of straight.
    """
    little = kinematics.segment_leverage(joint_angles) < _LITTLE
    return float(little[:, [0, 4]].any(axis=1).mean()), float(little[:, [2, 6]].any(axis=1).mean())
