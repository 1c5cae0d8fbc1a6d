"""Invented dances: as many and as long as are wanted, where no recordings are at hand."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.context import one_hot
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.minimum_jerk import minimum_jerk
from mpma_mj.motions.motion import Motion
from mpma_mj.utils.seeding import stream

__all__ = ["DANCES", "invented"]

DANCES = 16
_POSES = 5  # of a dance
_SECONDS_PER_POSE = 1.0
_MOVING = 0.8  # share of a pose's time that the move to it takes; the rest is held
# Within these key poses are drawn, uniformly: abduction, flexion, rotation, elbow, rad. Arms are
# anywhere beside and in front of the body, and out of reach of the joints' singular poses.
_LEAST = (0.0, -0.6, -0.9, 0.2)
_MOST = (2.4, 0.9, 0.9, 2.0)


def invented(rate: float = 20.0, tempo: float = 1.0, *, dance: int | None = None) -> Motion:
    """Return one of the invented dances, or all of them in a row.

    The movement is synthetic: key poses drawn at random, the same ones always, are joined in
    joint space by minimum-jerk moves. Nobody danced it, and it has no structure such as
    repetition or symmetry that people's dances have. All numbers of it are choices (choice).

    Args:
        rate: Postures per second, Hz.
        tempo: Speed relative to a pose a second.
        dance: Which of them, from 1 to `DANCES`, 5 s at tempo 1; all, 80 s, if not given.

    Returns:
        The motion, with a label for each dance, its number.

    Raises:
        BadOptionError: So fast or so coarsely sampled that a pose has no two samples.
    """
    samples = round(_SECONDS_PER_POSE / tempo * rate)
    if samples < 2:
        raise BadOptionError(
            f"rate {rate:g} and tempo {tempo:g} leave {samples} sample(s) a pose;"
            " a higher rate or a lower tempo is needed"
        )
    dances = range(DANCES) if dance is None else range(dance - 1, dance)
    keys = _key_angles()[dances.start * _POSES : dances.stop * _POSES + 1]
    share = minimum_jerk(np.arange(samples) / samples / _MOVING)[:, None]
    moves = [before + share * (key - before) for before, key in itertools.pairwise(keys)]
    danced = np.repeat(np.arange(len(dances)), _POSES * samples)
    return Motion(
        posture=kinematics.posture_from_angles(np.concatenate(moves)),
        context=one_hot(danced, len(dances)),
        labels=tuple(str(number + 1) for number in dances),
        rate=rate,
        name="invented" if dance is None else f"invented-{dance}",
        source="synthetic: random key poses, minimum-jerk moves",
        tempo=tempo,
    )


def _key_angles() -> NDArray[np.float64]:
    """Return the joint angles of the key poses of all dances, shape (K + 1, 8), rad."""
    shape = (DANCES * _POSES + 1, 2, 4)
    return stream(0, "invented dances").uniform(_LEAST, _MOST, shape).reshape(-1, 8)
