"""Feasible motion of any chain: the closest joint angles within its ranges and speeds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.chain_search import best_of_paths, starting_paths
from mpma_mj.motions.joint_fit import Seam, StepLimits, fit_joint_angles
from mpma_mj.robots.chain import Chain

__all__ = ["HEADROOM", "fit_chain"]

Array = NDArray[np.float64]

HEADROOM = 0.8
"""Share of the joints' top speed; the rest is the controller's (choice)."""

_BEYOND = 1.01  # of the largest step, up to which a fit counts as within the limits


def fit_chain(
    directions: Array, chain: Chain, max_speed: Array, rate: float, cyclic: bool
) -> Array:
    """Fit joint angles of a chain to a motion, within its ranges and 80 % of its top speeds.

    The fit has local minima; it is made from several paths (`starting_paths`) and then from the
    best path that changes between the fitted ones, and the closest is kept. Accelerations are not
    limited.

    Args:
        directions: Directions u and f, shape (T, 6), unit vectors.
        chain: The arm.
        max_speed: Top speeds of its joints, shape (4,), rad/s.
        rate: Steps per second, Hz.
        cyclic: Whether the end leads into the start.

    Returns:
        Joint angles, shape (T, 4), rad. Those of a cyclic motion lead on, too, within the same
        speeds; joints without a range may have turned by whole turns then.
    """
    limits = StepLimits(HEADROOM * max_speed / rate, chain.lowest, chain.highest)
    fits = [
        _fit(start, directions, chain, limits, cyclic)
        for start in starting_paths(directions, chain, limits, rate, cyclic)
    ]
    mixed = best_of_paths([angles for angles, _ in fits], directions, chain, limits, cyclic)
    fits.append(_fit(mixed, directions, chain, limits, cyclic))
    return min(fits, key=lambda fit: fit[1])[0]


def _fit(
    start: Array, directions: Array, chain: Chain, limits: StepLimits, cyclic: bool
) -> tuple[Array, tuple[bool, float]]:
    """Return a fit, shape (T, 4), rad, and whether it breaks a limit and its distance."""
    seam = None
    if cyclic:
        endless = np.isinf(chain.lowest) & np.isinf(chain.highest)
        turns = np.round((start[-1] - start[0]) / (2.0 * np.pi))
        seam = Seam(np.ones(4), np.where(endless, 2.0 * np.pi * turns, 0.0))
    angles, distance = fit_joint_angles(directions, chain.jacobian, start, limits, seam)
    steps = np.diff(angles, axis=0)
    if seam is not None:
        steps = np.concatenate([steps, angles[:1] + seam.offset - angles[-1:]])
    return angles, (bool((np.abs(steps) > _BEYOND * limits.step).any()), distance)
