"""Motions with joint angles that arms can follow, as close to the motion as their limits allow."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths, kinematics
from mpma_mj.motions.feasibility import JointLimits, beyond_limits
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.transforms import leads_on
from mpma_mj.robots.chain_arms import ChainArms

__all__ = ["fitted"]

Array = NDArray[np.float64]

_HEADROOM = 0.9  # share of the joints' top speed; the rest is the controller's (choice)
_KEPT = 16  # fits of a process, each of which takes up to seconds


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
