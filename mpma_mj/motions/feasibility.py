"""Feasibility: the joint angles and speeds that a motion demands, and those that arms can do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import InfeasibleMotionError, WriteOption, as_keyword
from mpma_mj.motions.motion import Motion

__all__ = ["check_feasibility", "check_ranges", "demand_lines", "joint_speeds", "near_singularity"]

Array = NDArray[np.float64]

# Leverage of a joint over its segment below which a pose counts as near a singularity: within
# 15° of straight forward or back, or an elbow straighter than that (choice).
_LITTLE = np.sin(np.radians(15.0))


def joint_speeds(motion: Motion) -> Array:
    """Return the speed that a motion demands of each joint, shape (T-1, 8), rad/s.

    Only the part that turns the segment counts (`kinematics.segment_leverage`): near a singular
    pose a joint may have to turn fast to move its segment hardly at all, and may as well lag.
    """
    angles = motion.joint_angles
    leverage = np.minimum(
        kinematics.segment_leverage(angles[1:]), kinematics.segment_leverage(angles[:-1])
    )
    return np.abs(np.diff(angles, axis=0)) * motion.rate * leverage


def check_feasibility(motion: Motion, max_joint_speed: Array, max_elbow: float) -> None:
    """Check that the arms can follow a motion.

    Args:
        motion: The motion.
        max_joint_speed: Largest speed of each joint, shape (8,), rad/s.
        max_elbow: Largest angle of an elbow, rad.

    Raises:
        InfeasibleMotionError: An elbow would have to bend too far, or a joint to turn too fast. The
            error names joint, frame, required and possible value, and a tempo that is feasible.
    """
    elbows = kinematics.angles_from_posture(motion.posture)[:, 3::4]
    frame, side = np.unravel_index(np.argmax(elbows), elbows.shape)
    if elbows[frame, side] > max_elbow:
        raise InfeasibleMotionError(
            f"{motion.name}: {kinematics.SIDES[side]}_elbow would have to bend by"
            f" {elbows[frame, side]:.2f} rad at {_place(motion, int(frame))}, but it bends up to"
            f" {max_elbow:g}; check that side's elbow and wrist markers"
        )
    ratio = joint_speeds(motion) / max_joint_speed
    frame, joint = np.unravel_index(np.argmax(ratio), ratio.shape)
    worst = ratio[frame, joint]
    if worst > 1.0:
        tempo = max(np.floor(95.0 * motion.tempo / worst) / 100.0, 0.01)
        raise InfeasibleMotionError(
            f"{motion.name}: {kinematics.JOINT_NAMES[joint]} would have to turn at"
            f" {worst * max_joint_speed[joint]:.1f} rad/s at {_place(motion, int(frame))}, but its"
            f" actuator reaches {max_joint_speed[joint]:g}",
            remedy=f"slow the motion with {{tempo={tempo:g}}} or less, or cut that moment off with"
            " {start} or {end}",
        )


def check_ranges(motion: Motion, lowest: Array, highest: Array) -> None:
    """Check that a motion stays within the ranges of the joints.

    Args:
        motion: The motion.
        lowest: Lowest joint angles, shape (8,), rad, -inf where there is none.
        highest: Highest joint angles, shape (8,), rad.

    Raises:
        InfeasibleMotionError: A joint angle is out of range. The error names joint, frame, required
            angle and range.
    """
    beyond = np.maximum(lowest - motion.joint_angles, motion.joint_angles - highest)
    frame, joint = np.unravel_index(np.argmax(beyond), beyond.shape)
    if beyond[frame, joint] > 0.0:
        raise InfeasibleMotionError(
            f"{motion.name}: {kinematics.JOINT_NAMES[joint]} would have to be at"
            f" {motion.joint_angles[frame, joint]:.2f} rad at {_place(motion, int(frame))}, but"
            f" its range is {lowest[joint]:g} to {highest[joint]:g}; widen the range in the model"
        )


def demand_lines(
    motion: Motion, max_joint_speed: Array, max_elbow: float, write: WriteOption = as_keyword
) -> list[str]:
    """Describe what a motion demands of the joints, in lines of text.

    Args:
        motion: The motion.
        max_joint_speed: Largest speed of each joint, shape (8,), rad/s.
        max_elbow: Largest angle of an elbow, rad.
        write: Writes an option as Python or the command line does.
    """
    lines = ["joints:                      range, rad      top speed of its limit, rad/s"]
    angles = motion.joint_angles
    fastest = joint_speeds(motion).max(axis=0)
    for joint, name in enumerate(kinematics.JOINT_NAMES):
        low, high = angles[:, joint].min(), angles[:, joint].max()
        mark = "  too fast" if fastest[joint] > max_joint_speed[joint] else ""
        lines.append(
            f"  {name:<25} {low:6.2f} to {high:5.2f}   {fastest[joint]:6.1f} of"
            f" {max_joint_speed[joint]:g}{mark}"
        )
    forward, straight = near_singularity(angles)
    lines.append(
        f"near a singularity: an upper arm points straight forward or back {100 * forward:.0f} %"
        f" of the time, an elbow is straight {100 * straight:.0f} %"
    )
    try:
        check_feasibility(motion, max_joint_speed, max_elbow)
        lines.append("the arms can follow it")
    except InfeasibleMotionError as error:
        lines.append(f"the arms cannot follow it: {error.describe(write)}")
    return lines


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


def _place(motion: Motion, frame: int) -> str:
    seconds = frame / motion.rate * motion.tempo
    return f"frame {frame + 1} of {len(motion)} ({seconds:.2f} s into the original)"
