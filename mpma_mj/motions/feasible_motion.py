"""Feasible motions: joint angles within the arms' limits that come closest to a motion."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.arm_kinematics import ArmKinematics
from mpma_mj.errors import InfeasibleMotionError
from mpma_mj.motions.feasibility import CHANGED, JointLimits, beyond_limits, turned
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.transforms import leads_on
from mpma_mj.robots.chain_arms import ChainArms

__all__ = ["MotionChange", "feasible", "feasible_tempo", "fitted"]

Array = NDArray[np.float64]

_HEADROOM = 0.9  # share of the joints' top speed; the rest is the controller's (choice)
_KEPT = 16  # fits of a process, each of which takes up to seconds


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
        from mpma_mj.motions.reach import slower_tempo  # which uses this module

        change = dataclasses.replace(change, remedy=slower_tempo(own, limits))
    return own, change if change.changed else None


def fitted(motion: Motion, limits: JointLimits) -> tuple[Motion, str]:
    """Return a motion with joint angles within the limits of arms, and why it has them.

    A motion within the limits of `two_arm` is returned as it is. Otherwise joint angles are fitted
    to the whole motion within the ranges of joints and 90 % of their speeds, and cyclic where its
    end leads into its start; those of other robots in any case. They become `feasible_angles`; the
    posture stays, so that errors are those from the original.

    Args:
        motion: The motion.
        limits: Limits of the arms.

    Returns:
        The motion, and why it was fitted; empty where it is as it was.
    """
    arms = limits.kinematics
    if motion.angles_of != arms.name:
        motion = dataclasses.replace(motion, feasible_angles=None)
    if motion.feasible_angles is None and isinstance(arms, ChainArms):
        reason = f"{arms.robot} has joints and speeds of its own"
    else:
        reason = beyond_limits(motion, limits)
    if not reason:
        return motion, ""
    original = dataclasses.replace(motion, feasible_angles=None)
    if isinstance(arms, ChainArms):
        speeds, cyclic = (_HEADROOM * limits.max_speed).tobytes(), leads_on(original)
        angles = _fitted_to_chains(original.posture.tobytes(), original.rate, cyclic, speeds, arms)
    else:
        angles = _fitted(original, limits)
    return dataclasses.replace(motion, feasible_angles=angles, angles_of=arms.name), reason


def feasible_tempo(read: Callable[[float], Motion], limits: JointLimits) -> float:
    """Return a tempo, up to 1, at which nothing of a motion has to be changed.

    A slower motion is sampled more finely and may show higher peaks, so that tempos are tried. For
    other robots than `two_arm` it is one at which all postures are within 5° (`close_tempo`).

    Args:
        read: Reads the motion at a tempo.
        limits: Limits of the arms.

    Returns:
        The tempo: at the next 0.01 more, 0.05 for other robots, it is not so.

    Raises:
        InfeasibleMotionError: None was found, as a joint would have to leave its range.
    """
    if isinstance(limits.kinematics, ChainArms):
        from mpma_mj.motions.reach import close_tempo

        tempo, share = close_tempo(read, limits)
        if share < 1.0:
            raise InfeasibleMotionError(
                f"no tempo is slow enough: at {tempo:g} only {100 * share:.1f} % of the steps are"
                " within 5°",
                remedy=f"leave out {{tempo}}, or give {{tempo={tempo:g}}}",
            )
        return tempo
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


def _fitted(motion: Motion, limits: JointLimits) -> Array:
    """Return the joint angles that come closest to a motion, shape (T, 8), rad."""
    # Here, as scipy takes longer to import than most motions, which need no fit, to read.
    from mpma_mj.motions.branch_search import best_branches
    from mpma_mj.motions.joint_fit import Seam, StepLimits, fit_joint_angles

    start, cyclic = motion.joint_angles, leads_on(motion)
    sign, offset = joint_paths.continuation(start[0], near=start[-1])
    angles = np.empty_like(start)
    for arm, directions in enumerate(kinematics.as_left_arms(motion.posture)):
        own = slice(4 * arm, 4 * arm + 4)
        lowest, highest = limits.lowest[own], limits.highest[own]
        step = _HEADROOM * limits.max_speed[own] / motion.rate
        arm_limits = StepLimits(step, lowest, highest)
        limited = np.isfinite(lowest[:3]).any() or np.isfinite(highest[:3]).any()
        starts = [start[:, own]]
        if limited:  # other branches and turns may lie within the ranges
            starts.append(best_branches(directions, arm_limits))
        seam = Seam(sign[own], offset[own]) if cyclic and not limited else None
        fits = [
            fit_joint_angles(directions, kinematics.segment_jacobian, one, arm_limits, seam)
            for one in starts
        ]
        angles[:, own] = min(fits, key=lambda fit: fit[1])[0]
    return angles


@functools.lru_cache(maxsize=_KEPT)
def _fitted_to_chains(
    posture: bytes, rate: float, cyclic: bool, max_speed: bytes, arms: ChainArms
) -> Array:
    """Return the joint angles of other arms that come closest to a motion, shape (T, 8), rad."""
    from mpma_mj.motions.chain_fit import fit_chain

    directions = np.frombuffer(posture).reshape(-1, 2, 6)
    speeds = np.frombuffer(max_speed).reshape(2, 4)
    fits = [
        fit_chain(directions[:, arm], chain, speeds[arm], rate, cyclic)
        for arm, chain in enumerate(arms.chains)
    ]
    return np.concatenate(fits, axis=1)


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
