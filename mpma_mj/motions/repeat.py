"""A movement danced several times in a row."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.motions.minimum_jerk import PEAK_SPEED, minimum_jerk
from mpma_mj.motions.motion import Motion

__all__ = ["repeat", "way_between"]

Array = NDArray[np.float64]

# Share of the joints' top speed at which arms go from one movement to the next (choice).
_SPEED = 0.5
# A step is like those within so many seconds if it is up to so many times as long (choice).
_AROUND = 0.25
_LIKE = 1.2


def repeat(motion: Motion, times: int, max_joint_speed: Array) -> tuple[Array, Array]:
    """Join repetitions of a movement.

    Where it ends elsewhere than it starts, the arms return by a minimum-jerk move, as long as
    it takes at half the joints' top speed; its context is that of the movement's first posture.
    A movement whose end leads into its start within one sample, at rest or at the speed that it
    has there, is joined as it is.

    Args:
        motion: The movement, T postures.
        times: How often it is danced.
        max_joint_speed: Fastest that each joint can turn, shape (8,), rad/s.

    Returns:
        Posture, shape (T', 12), and context, shape (T', C).
    """
    way_back = np.empty((0, 12))
    if not _leads_on(motion):
        way_back = way_between(motion, motion.posture[0], max_joint_speed)
    back_context = np.repeat(motion.context[:1], len(way_back), axis=0)
    posture = [motion.posture, way_back] * times
    context = [motion.context, back_context] * times
    return np.concatenate(posture[:-1]), np.concatenate(context[:-1])


def _leads_on(motion: Motion) -> bool:
    """Tell whether the step from a movement's end to its start is like those around it."""
    near = 1 + max(1, round(_AROUND * motion.rate))
    step = motion.posture[0] - motion.posture[-1]
    around = [np.diff(motion.posture[stretch], axis=0) for stretch in (np.s_[:near], np.s_[-near:])]
    return _longest(step) <= _LIKE * max(map(_longest, around))


def _longest(steps: Array) -> float:
    return float(np.linalg.norm(steps.reshape(-1, 3), axis=1).max())


def way_between(motion: Motion, after: Array, max_joint_speed: Array) -> Array:
    """Return a minimum-jerk move from the end of a movement to another posture.

    Args:
        motion: The movement.
        after: Posture to which the move leads, shape (12,).
        max_joint_speed: Fastest that each joint can turn, shape (8,), rad/s.

    Returns:
        The postures in between, shape (N, 12); N is 0 where one sample is enough.
    """
    end = motion.joint_angles[-1]
    way = kinematics.angles_from_posture(after, near=end) - end
    time = PEAK_SPEED * np.max(np.abs(way) / max_joint_speed) / _SPEED  # s
    count = int(np.ceil(time * motion.rate))
    if count <= 1:
        return np.empty((0, 12))
    share = minimum_jerk(np.arange(1, count) / count)[:, None]
    return kinematics.posture_from_angles(end + share * way)
