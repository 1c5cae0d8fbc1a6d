"""What a movement asks of the joints, beside what they can do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import MotionReachError
from mpma_mj.motions.motion import Motion

__all__ = ["check_feasibility", "check_ranges", "joint_speeds"]

Array = NDArray[np.float64]


def joint_speeds(motion: Motion) -> Array:
    """Compute the speed that a movement asks of every joint.

    Counted is the part of the speed that turns the segment (`kinematics.segment_leverage`): near a
    singular pose a joint may have to whip round to move its segment hardly at all, and is not
    missed there.

    Args:
        motion: The movement, T postures.

    Returns:
        Speed between each posture and the next, shape (T-1, 8), rad/s.
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
        MotionReachError: An elbow would have to bend too far, or a joint to turn too fast. The
            error names joint, frame, required and possible value, and a tempo that is feasible.
    """
    elbows = kinematics.angles_from_posture(motion.posture)[:, 3::4]
    frame, side = np.unravel_index(np.argmax(elbows), elbows.shape)
    if elbows[frame, side] > max_elbow:
        raise MotionReachError(
            f"{motion.name}: {kinematics.SIDES[side]}_elbow would have to bend by"
            f" {elbows[frame, side]:.2f} rad at {_place(motion, int(frame))}, it bends up to"
            f" {max_elbow:g}; check that side's elbow and wrist markers"
        )
    ratio = joint_speeds(motion) / max_joint_speed
    frame, joint = np.unravel_index(np.argmax(ratio), ratio.shape)
    worst = ratio[frame, joint]
    if worst > 1.0:
        tempo = max(np.floor(95.0 * motion.tempo / worst) / 100.0, 0.01)
        raise MotionReachError(
            f"{motion.name}: {kinematics.JOINT_NAMES[joint]} would have to turn at"
            f" {worst * max_joint_speed[joint]:.1f} rad/s at {_place(motion, int(frame))}, its"
            f" actuator reaches {max_joint_speed[joint]:g}",
            remedy=f"slow the movement with {{tempo={tempo:g}}} or less, or leave that moment out"
            " with {start} or {end}",
        )


def check_ranges(motion: Motion, lowest: Array, highest: Array) -> None:
    """Check that a motion stays within the ranges of the joints.

    Args:
        motion: The motion.
        lowest: Lowest joint angles, shape (8,), rad, -inf where there is none.
        highest: Highest joint angles, shape (8,), rad.

    Raises:
        MotionReachError: A joint angle is out of range. The error names joint, frame, required
            angle and range.
    """
    beyond = np.maximum(lowest - motion.joint_angles, motion.joint_angles - highest)
    frame, joint = np.unravel_index(np.argmax(beyond), beyond.shape)
    if beyond[frame, joint] > 0.0:
        raise MotionReachError(
            f"{motion.name}: {kinematics.JOINT_NAMES[joint]} would have to be at"
            f" {motion.joint_angles[frame, joint]:.2f} rad at {_place(motion, int(frame))}, its"
            f" range is {lowest[joint]:g} to {highest[joint]:g}; widen the range in the model"
        )


def _place(motion: Motion, frame: int) -> str:
    seconds = frame / motion.rate * motion.tempo
    return f"frame {frame + 1} of {len(motion)} ({seconds:.2f} s into the original)"
