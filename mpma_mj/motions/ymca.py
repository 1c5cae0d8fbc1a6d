"""The built-in movement: the arms of the dance to "YMCA"."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.context import one_hot
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.minimum_jerk import minimum_jerk
from mpma_mj.motions.motion import Motion

__all__ = ["ymca"]

LETTERS = ("Y", "M", "C", "A")
BEATS_PER_MINUTE = 127.0  # tempo of the Village People's recording of 1978
BEATS_PER_LETTER = 2.0
BEATS_PER_MOVE = 1.5  # the rest of a letter is held (choice)

# Key poses as seen by the audience: for each arm the direction of upper arm and forearm in the
# torso frame (forward, left, up), not yet of length 1.
KEY_POSES = {
    "Y": ((0.10, 0.62, 0.78), (0.12, 0.55, 0.83), (0.10, -0.62, 0.78), (0.12, -0.55, 0.83)),
    "M": ((0.20, 0.82, 0.53), (0.25, -0.50, -0.83), (0.20, -0.82, 0.53), (0.25, 0.50, -0.83)),
    "C": ((0.25, 0.55, -0.80), (0.25, 0.94, 0.25), (0.15, -0.45, 0.88), (0.20, 0.88, 0.42)),
    "A": ((0.12, 0.25, 0.96), (0.10, -0.80, 0.59), (0.12, -0.25, 0.96), (0.10, 0.80, 0.59)),
}


def ymca(rate: float = 20.0, tempo: float = 1.0) -> Motion:
    """Return the YMCA choreography, one pass through the four letters.

    The movement is synthetic, not recorded: the paper's own recording is not public. Four key
    poses, drawn by hand after the well-known dance, are joined in joint space by minimum-jerk
    moves, one letter every two beats of the song. The time of a letter is rounded to whole
    samples, so that repetitions join without a jump. The context is one-hot, a letter's entry
    being 1 from the start of the move towards it to the end of its hold.

    Args:
        rate: Postures per second, Hz.
        tempo: Speed relative to the song.

    Returns:
        The motion, with labels Y, M, C, A.

    Raises:
        BadOptionError: So fast or so coarsely sampled that a letter has no two samples.
    """
    samples = round(BEATS_PER_LETTER * 60.0 / (BEATS_PER_MINUTE * tempo) * rate)
    if samples < 2:
        raise BadOptionError(
            f"rate {rate:g} and tempo {tempo:g} leave {samples} sample(s) a letter;"
            " a higher rate or a lower tempo is needed"
        )
    keys = _key_angles()
    phase = np.arange(samples) / samples * BEATS_PER_LETTER / BEATS_PER_MOVE
    share = minimum_jerk(phase)[:, None]
    moves = [keys[i - 1] + share * (keys[i] - keys[i - 1]) for i in range(len(LETTERS))]
    return Motion(
        posture=kinematics.posture_from_angles(np.concatenate(moves)),
        context=one_hot(np.repeat(np.arange(len(LETTERS)), samples), len(LETTERS)),
        labels=LETTERS,
        rate=rate,
        name="ymca",
        source="synthetic: hand-drawn key poses of the letters Y, M, C, A, minimum-jerk moves",
        tempo=tempo,
    )


def _key_angles() -> NDArray[np.float64]:
    """Return the joint angles of the letters, shape (4, 8), rad."""
    poses = np.array([np.ravel(KEY_POSES[letter]) for letter in LETTERS])
    return kinematics.continuous_angles(poses, start=np.zeros(8))
