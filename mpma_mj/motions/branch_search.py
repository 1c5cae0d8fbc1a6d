"""Search for joint angles of an arm over a whole motion, among branches, turns and free angles.

A dynamic program over candidates for the joint angles of each step: both exact branches, a grid of
abductions and, on the exact branches, a grid of rotations, as these may be nearly free; each with
the whole turns that lie within the joints' ranges. It is a start for a fit where ranges exclude the
nearest branch.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.motions.cheapest_path import cheapest_path
from mpma_mj.motions.joint_fit import StepLimits

__all__ = ["best_branches"]

Array = NDArray[np.float64]

# Choices.
_ABDUCTIONS, _ROTATIONS = 32, 16  # angles of the grids
_UNLIMITED = 4.0  # rad: range of joints without one, more than a turn


def best_branches(directions: Array, limits: StepLimits) -> Array:
    """Return joint angles of a left arm with the least cost, as good as the grids allow.

    Args:
        directions: Directions u and f, shape (T, 6).
        limits: Limits of the four joints.

    Returns:
        Joint angles, shape (T, 4), rad, within the ranges.
    """
    lowest, highest = np.maximum(limits.lowest, -_UNLIMITED), np.minimum(limits.highest, _UNLIMITED)
    angles = _candidates(directions)
    angles = np.clip(angles, np.where(_ELBOW, lowest, -np.inf), np.where(_ELBOW, highest, np.inf))
    angles = _with_turns(angles)
    within = ((angles >= lowest) & (angles <= highest)).all(axis=-1)
    shown = kinematics.segment_jacobian(angles.reshape(-1, 4))[0].reshape(*angles.shape[:2], 6)
    distance = np.where(within, np.sum((shown - directions[:, None]) ** 2, axis=-1), np.inf)
    if not np.all(np.any(within, axis=1)):  # ranges of less than a step of the grids
        return np.clip(angles[:, 0], lowest, highest)

    return cheapest_path(angles, distance, limits.step)


_ELBOW = np.array([False, False, False, True])


def _candidates(directions: Array) -> Array:
    """Return joint angles that hold directions, (T, 6), or nearly do, shape (T, N, 4), rad."""
    frames = len(directions)
    exact = np.arctan2(directions[:, 1], -directions[:, 2])[:, None]
    grid = np.linspace(-np.pi, np.pi, _ABDUCTIONS, endpoint=False)
    abduction = np.concatenate([exact, exact + np.pi, np.tile(grid, (frames, 1))], axis=1)
    spread = np.broadcast_to(directions[:, None], (*abduction.shape, 6))
    flexion, rotation, elbow = kinematics.after_abduction(spread, abduction)
    angles = np.stack([abduction, flexion, rotation, elbow], axis=-1)
    free = np.repeat(angles[:, :2, None], _ROTATIONS, axis=2)
    free[..., 2] = np.linspace(-np.pi, np.pi, _ROTATIONS, endpoint=False)
    # The elbow that comes nearest with a rotation that is off by some angle.
    off = np.cos(free[..., 2] - rotation[:, :2, None])
    bend = elbow[:, :2, None]
    free[..., 3] = np.arctan2(np.maximum(np.sin(bend) * off, 0.0), np.cos(bend))
    return np.concatenate([angles, free.reshape(frames, -1, 4)], axis=1)


def _with_turns(angles: Array) -> Array:
    """Return joint angles, (T, N, 4), and those a turn of a joint away, in all (T, 8N, 4)."""
    wrapped = angles.copy()
    wrapped[..., :3] = kinematics.wrap(wrapped[..., :3])
    turned = wrapped.copy()
    turned[..., :3] -= 2.0 * np.pi * np.sign(wrapped[..., :3])
    choices = itertools.product((False, True), repeat=3)
    return np.concatenate(
        [np.where([*choice, False], turned, wrapped) for choice in choices], axis=1
    )
