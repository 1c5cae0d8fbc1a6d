"""Feasible motions: joint angles within the arms' limits that come closest to a motion."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.arm_kinematics import ArmKinematics
from mpma_mj.errors import InfeasibleMotionError
from mpma_mj.motions.feasibility import CHANGED, JointLimits, turned
from mpma_mj.motions.fitted_motion import fitted
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.reach import close_tempo, slower_tempo
from mpma_mj.robots.chain_arms import ChainArms

__all__ = ["MotionChange", "feasible", "feasible_tempo"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MotionChange:
    """What had to be changed of a motion.

    Attributes:
        reason: Which joint would have to do what, and where.
        changed: Share of the steps of which a segment is turned by more than 1°.
        mean: Mean of the largest change of each step, degrees.
        largest: Largest change, degrees.
        where: Segment and time of the largest change.
        unavoidable: Posture error that no controller can avoid, percent.
        remedy: What would change less, with a place for the option; empty if unknown.
    """

    reason: str
    changed: float
    mean: float
    largest: float
    where: str
    unavoidable: float
    remedy: str = ""

    def __str__(self) -> str:
        """Return it in one line."""
        return (
            f"{self.reason}; in the closest motion that the arms can follow"
            f" {100 * self.changed:.1f} % of the steps are changed by more than {CHANGED:g}°, all"
            f" by {self.mean:.2f}° in the mean and {self.largest:.1f}° at most ({self.where}), an"
            f" error of {self.unavoidable:.2f} % that no controller can avoid"
        )


def feasible(motion: Motion, limits: JointLimits) -> tuple[Motion, MotionChange | None]:
    """Return a motion that arms can follow, and what was changed of it.

    Args:
        motion: The motion.
        limits: Limits of the arms.

    Returns:
        The motion, as of `fitted`; and the change, None where no segment is turned by more than 1°.
    """
    own, reason = fitted(motion, limits)
    if not reason:
        return own, None
    change = _change(own, reason, limits.kinematics)
    if isinstance(limits.kinematics, ChainArms):
        change = dataclasses.replace(change, remedy=slower_tempo(own, limits))
    return own, change if change.changed else None


def feasible_tempo(read: Callable[[float], Motion], limits: JointLimits) -> float:
    """Return a tempo, up to 1, at which nothing of a motion has to be changed.

    A slower motion is sampled more finely and may show higher peaks, so that tempos are tried. For
    other robots than `two_arm` it is one at which nearly all is feasible that ever is
    (`close_tempo`).

    Args:
        read: Reads the motion at a tempo.
        limits: Limits of the arms.

    Returns:
        The tempo: at the next 0.01 more, 0.05 for other robots, it is not so.

    Raises:
        InfeasibleMotionError: None was found, as a joint would have to leave its range.
    """
    if isinstance(limits.kinematics, ChainArms):
        return close_tempo(read, limits)[0]
    passes, fails, tried = 0, 101, 100  # hundredths
    while fails - passes > 1:
        change = feasible(read(tried / 100.0), limits)[1]
        if change is None:
            passes = tried
        else:
            fails = tried
        if fails == 1:
            raise InfeasibleMotionError(
                f"no tempo is slow enough: {change}", remedy="leave out {tempo}"
            )
        tried = (passes + fails) // 2
    return passes / 100.0


def _change(motion: Motion, reason: str, arms: ArmKinematics) -> MotionChange:
    from mpma_mj.metrics import posture_error_percent

    degrees = turned(motion, arms)
    step, segment = np.unravel_index(np.argmax(degrees), degrees.shape)
    most = degrees.max(axis=1)
    shown = arms.posture(motion.joint_angles)
    name = kinematics.SEGMENT_NAMES[segment].replace("_", " ")
    return MotionChange(
        reason=reason,
        changed=float(np.mean(most > CHANGED)),
        mean=float(most.mean()),
        largest=float(most.max()),
        where=f"{name} at {motion.time(int(step)):.2f} s",
        unavoidable=posture_error_percent(shown, motion.posture),
    )
