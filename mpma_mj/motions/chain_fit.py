"""Feasible motion of any chain: the closest joint angles within its ranges and speeds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.chain_search import interpolated, starting_paths
from mpma_mj.motions.joint_fit import Seam, StepLimits, fit_joint_angles
from mpma_mj.robots.chain import Chain

__all__ = ["fit_chain"]

Array = NDArray[np.float64]

# Choices.
_HALVINGS = 2  # of the tempo
_SHORTEST = 8  # steps of a motion that is made faster


def fit_chain(
    directions: Array, chain: Chain, max_speed: Array, rate: float, cyclic: bool
) -> Array:
    """Fit joint angles of a chain to a motion, within ranges and speeds.

    As a fit has local minima, it starts from several paths (`starting_paths`), among them the fit
    of the same motion at twice and four times its tempo, so that a slower tempo is not worse. The
    closest is kept. Accelerations are not limited.

    Args:
        directions: Directions u and f, shape (T, 6), unit vectors.
        chain: The arm.
        max_speed: Largest speeds of its joints, shape (4,), rad/s.
        rate: Steps per second, Hz.
        cyclic: Whether the end leads into the start.

    Returns:
        Joint angles, shape (T, 4), rad. Those of a cyclic motion lead on within the same speeds,
        too, where joints without a range may have made whole turns.
    """
    return _closest(directions, chain, max_speed / rate, rate, cyclic, _HALVINGS)


def _closest(
    directions: Array, chain: Chain, step: Array, rate: float, cyclic: bool, halvings: int
) -> Array:
    starts = starting_paths(directions, chain, step, rate, cyclic)
    if halvings and len(directions) > _SHORTEST:
        faster = _closest(directions[::2], chain, step, rate, cyclic, halvings - 1)
        starts.append(interpolated(faster, 2, len(directions), chain, cyclic))
    fits = [_fit(start, directions, chain, step, cyclic) for start in starts]
    return min(fits, key=lambda fit: fit[1])[0]


def _fit(
    start: Array, directions: Array, chain: Chain, step: Array, cyclic: bool
) -> tuple[Array, float]:
    """Return a fit, shape (T, 4), rad, and its distance."""
    seam = None
    if cyclic:
        most = np.floor(len(start) * step / (2.0 * np.pi))  # turns that the speeds allow
        turns = np.clip(np.round((start[-1] - start[0]) / (2.0 * np.pi)), -most, most)
        seam = Seam(np.ones(4), np.where(chain.endless, 2.0 * np.pi * turns, 0.0))
    limits = StepLimits(step, chain.lowest, chain.highest)
    return fit_joint_angles(directions, chain.jacobian, start, limits, seam)
