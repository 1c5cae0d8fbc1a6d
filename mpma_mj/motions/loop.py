"""A movement bent so that its end leads into its start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.motions.minimum_jerk import minimum_jerk

__all__ = ["close_loop"]

Array = NDArray[np.float64]

_SHARE = 0.25  # of the movement that is bent ...
_LONGEST = 2.0  # ... at most so many seconds (choice)


def close_loop(posture: Array, rate: float) -> Array:
    """Bend the last part of a movement so that repetitions join without a jump.

    The joint angles are shifted by a share of the way from the end to the start that rises
    along a minimum-jerk curve from 0 to 1, one sample after the end. Elbows keep to how far they
    bend in the movement, so that none is bent backwards.

    Args:
        posture: Postures, shape (T, 12).
        rate: Postures per second, Hz.

    Returns:
        Postures, shape (T, 12): the first ones as they were.
    """
    angles = kinematics.continuous_angles(posture)
    count = max(1, min(round(_LONGEST * rate), int(_SHARE * len(posture))))
    # Where the movement would be one sample after its end, and where it should be.
    end = 2.0 * angles[-1] - angles[-2]
    way = kinematics.angles_from_posture(posture[0], near=end) - end
    share = minimum_jerk(np.arange(1, count + 1) / (count + 1))[:, None]
    elbows = angles[:, 3::4]  # a view
    least, most = elbows.min(axis=0), elbows.max(axis=0)
    angles[-count:] += share * way
    np.clip(elbows, least, most, out=elbows)
    return kinematics.posture_from_angles(angles)
