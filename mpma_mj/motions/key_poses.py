"""Motions through key poses: minimum-jerk moves between joint angles, in whole samples."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.transforms import minimum_jerk

__all__ = ["moves", "whole_samples"]

Array = NDArray[np.float64]


def whole_samples(seconds: float, part: str, rate: float, tempo: float) -> int:
    """Return the number of samples of a part of a motion.

    Args:
        seconds: Duration of the part at its tempo, s.
        part: What an error calls it.
        rate: Postures per second, Hz.
        tempo: Tempo, for the error.

    Raises:
        BadOptionError: There are fewer than 2.
    """
    samples = round(seconds * rate)
    if samples < 2:
        raise BadOptionError(
            f"rate {rate:g} and tempo {tempo:g} leave {samples} sample(s) a {part};"
            " expected at least 2",
            remedy="give a lower {tempo}",
        )
    return samples


def moves(keys: Iterable[Array], phase: Array) -> Array:
    """Return postures of minimum-jerk moves between joint angles, one after the other.

    Args:
        keys: K joint angles, each shape (8,), rad.
        phase: Phases of each move, shape (T,); from 1 on the key that is reached is held.

    Returns:
        Postures, shape ((K - 1) · T, 12).
    """
    share = minimum_jerk(phase)[:, None]
    paths = [before + share * (key - before) for before, key in itertools.pairwise(keys)]
    return kinematics.posture_from_angles(np.concatenate(paths))
