"""Built-in synthetic motions: YMCA, and motions through random key poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths
from mpma_mj.context import one_hot
from mpma_mj.motions.key_poses import moves, whole_samples
from mpma_mj.motions.motion import Motion
from mpma_mj.utils.seeding import stream

__all__ = ["SYNTHETIC_MOTIONS", "synthetic_motion", "ymca"]

Array = NDArray[np.float64]

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

SYNTHETIC_MOTIONS = 16
_POSES = 5  # of a motion
_SECONDS_PER_POSE = 1.0
_MOVING = 0.8  # share of a pose's time that the move to it takes; the rest is held
# Within these key poses are drawn, uniformly: abduction, flexion, rotation, elbow, rad. Arms are
# anywhere to the side and in front of the body, and out of reach of the joints' singular poses.
_LEAST = (0.0, -0.6, -0.9, 0.2)
_MOST = (2.4, 0.9, 0.9, 2.0)


def ymca(rate: float = 20.0, tempo: float = 1.0) -> Motion:
    """Return the YMCA choreography, one pass through the four letters.

    The motion is synthetic, not recorded: the paper's own recording is not public. Four key
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
    beats = BEATS_PER_LETTER * 60.0 / (BEATS_PER_MINUTE * tempo)  # s a letter
    samples = whole_samples(beats, "letter", rate, tempo)
    phase = np.arange(samples) / samples * BEATS_PER_LETTER / BEATS_PER_MOVE
    keys = _letter_angles()
    return Motion(
        posture=moves([keys[-1], *keys], phase),
        context=one_hot(np.repeat(np.arange(len(LETTERS)), samples), len(LETTERS)),
        labels=LETTERS,
        rate=rate,
        name="ymca",
        source="synthetic: hand-drawn key poses of the letters Y, M, C, A, minimum-jerk moves",
        tempo=tempo,
    )


def synthetic_motion(
    rate: float = 20.0, tempo: float = 1.0, *, number: int | None = None
) -> Motion:
    """Return one of the synthetic motions, or all of them in a row.

    Key poses drawn at random, always the same ones, are joined in joint space by minimum-jerk
    moves. Unlike human motion they have no repetition or symmetry. All numbers are choices
    (choice).

    Args:
        rate: Postures per second, Hz.
        tempo: Speed relative to a pose a second.
        number: Which of them, from 1 to `SYNTHETIC_MOTIONS`, 5 s at tempo 1; None for all, 80 s.

    Returns:
        The motion, with the number of each synthetic motion as its label.

    Raises:
        BadOptionError: So fast or so coarsely sampled that a pose has no two samples.
    """
    samples = whole_samples(_SECONDS_PER_POSE / tempo, "pose", rate, tempo)
    indices = range(SYNTHETIC_MOTIONS) if number is None else range(number - 1, number)
    keys = _random_angles()[indices.start * _POSES : indices.stop * _POSES + 1]
    segments = np.repeat(np.arange(len(indices)), _POSES * samples)
    return Motion(
        posture=moves(keys, np.arange(samples) / samples / _MOVING),
        context=one_hot(segments, len(indices)),
        labels=tuple(str(index + 1) for index in indices),
        rate=rate,
        name="synthetic" if number is None else f"synthetic-{number}",
        source="synthetic: random key poses, minimum-jerk moves",
        tempo=tempo,
    )


def _letter_angles() -> Array:
    """Return the joint angles of the letters, shape (4, 8), rad."""
    poses = np.array([np.ravel(KEY_POSES[letter]) for letter in LETTERS])
    return joint_paths.continuous_angles(poses, start=np.zeros(8))


def _random_angles() -> Array:
    """Return the joint angles of all random key poses, shape (K + 1, 8), rad."""
    shape = (SYNTHETIC_MOTIONS * _POSES + 1, 2, 4)
    return stream(0, "invented dances").uniform(_LEAST, _MOST, shape).reshape(-1, 8)
