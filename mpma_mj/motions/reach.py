"""What a movement asks of the joints, beside what they can do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import arm
from mpma_mj.errors import MotionTooFastError
from mpma_mj.feedback import POLE_WIDTH
from mpma_mj.motions.motion import Motion

__all__ = ["check_speed", "joint_speeds"]

Array = NDArray[np.float64]


def joint_speeds(motion: Motion) -> Array:
    """Compute the speed that a movement asks of every joint.

    Counted is the part of the speed that turns the segment (`arm.segment_leverage`): near a
    singular pose a joint may have to whip round to move its segment hardly at all, and is not
    missed there.

    Args:
        motion: The movement, T postures.

    Returns:
        Speed between each posture and the next, shape (T-1, 8), rad/s.
    """
    angles = arm.continuous_angles(motion.posture, pole_width=POLE_WIDTH)
    leverage = np.minimum(arm.segment_leverage(angles[1:]), arm.segment_leverage(angles[:-1]))
    return np.abs(np.diff(angles, axis=0)) * motion.rate * leverage


def check_speed(motion: Motion, max_joint_speed: Array) -> None:
    """Refuse a movement that is faster than the arms.

    Args:
        motion: The movement.
        max_joint_speed: Fastest that each joint can turn, shape (8,), rad/s.

    Raises:
        MotionTooFastError: Names the joint, the frame, the speed, and a tempo that would do.
    """
    ratio = joint_speeds(motion) / max_joint_speed
    frame, joint = np.unravel_index(np.argmax(ratio), ratio.shape)
    worst = ratio[frame, joint]
    if worst > 1.0:
        tempo = np.floor(95.0 / worst) / 100.0
        raise MotionTooFastError(
            f"{motion.name}: {arm.JOINT_NAMES[joint]} would have to turn at"
            f" {worst * max_joint_speed[joint]:.1f} rad/s at frame {frame + 1}"
            f" ({frame / motion.rate:.2f} s), its actuator reaches {max_joint_speed[joint]:g};"
            f" slow the movement with --tempo {max(tempo, 0.01):g}"
        )
