"""Motions made by hand: a wave through both arms, and a conductor who beats four."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.context import one_hot
from mpma_mj.motions.key_poses import whole_samples
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.transforms import minimum_jerk

__all__ = ["BARS", "BEAT", "FIGURES", "conductor", "wave"]

Array = NDArray[np.float64]

_BEATS = 4  # of a bar

# Wave: shoulders and forearms swing, each a little later than its neighbour.
_WAVE_TEMPO = 108.0  # beats per minute
_SWINGS = 2  # of a bar
_CHANGE = 0.5  # share of a bar in which one figure becomes the next
_SWING = (0.35, 0.75)  # of abduction and rotation, rad, to either side
_FORWARD, _ELBOW = 0.2, 0.8  # flexion and elbow, rad

FIGURES = {
    "left": (1.45, (2, 3, 1, 0)),
    "right": (1.45, (1, 0, 2, 3)),
    "both": (2.1, (0, 1, 0, 1)),
    "in turn": (1.2, (4, 5, 0, 1)),
}
"""Figures of the wave, which runs to the left, to the right, through both arms together, or through
one after the other: mean abduction, rad, and when a crest passes left upper arm and forearm,
right upper arm and forearm, in eighths of a swing."""

# Conductor: ways of the wrists through points at each half of a beat, beginning with the first.
# A point is a wrist as seen from its shoulder, (forward, outward, up), in lengths of an upper arm,
# which the forearm is long, too.
_CONDUCTOR_TEMPO = 96.0  # beats per minute

BEAT = (
    *((1.25, 0.15, -1.05), (1.30, 0.10, -0.45)),  # down
    *((1.30, -0.20, -0.80), (1.35, 0.00, -0.30)),  # in
    *((1.05, 1.15, -0.75), (1.05, 0.95, -0.10)),  # out
    *((1.20, 0.45, -0.60), (1.05, 0.35, 0.95)),  # up
)
"""The four of the right hand: each beat and the rebound after it."""

_LOW, _HIGH = (0.95, 0.40, -1.00), (1.05, 0.70, 0.90)
BARS = {
    "mirror": BEAT,
    "cue": (
        *((1.10, 0.20, -0.60), (0.95, 0.25, -0.80), (0.85, 0.25, -0.80), (0.90, 0.35, -0.40)),
        *((1.40, 1.15, 0.20), (1.35, 1.15, 0.15), (1.15, 0.70, -0.55), _LOW),
    ),
    "swell": (*np.linspace(_LOW, _HIGH, 8),),
    "fade": (*np.linspace(_HIGH, _LOW, 7), BEAT[-1]),
}
"""Bars of the left hand: it mirrors the right one, gives a cue on the third beat, rises, sinks."""

_ELBOWS_TO = np.array([-0.3, 0.6, -1.0])  # side to which elbows point: back, outward, down


def wave(rate: float = 20.0, tempo: float = 1.0) -> Motion:
    """Return a wave that runs through both arms, four bars with a figure each.

    The motion is made by hand, not recorded. Abduction and rotation swing sinusoidally, twice a
    bar at 108 beats per minute, while flexion and elbow stay; the wave runs to the left, to the
    right, through both arms together and through one after the other. In the first half of a bar
    delays and mean change along a minimum-jerk curve. All numbers are choices (choice).

    Args:
        rate: Postures per second, Hz.
        tempo: Speed relative to 108 beats per minute.

    Returns:
        The motion, with the figures as labels.

    Raises:
        BadOptionError: So fast or so coarsely sampled that a bar has no two samples.
    """
    bars = _times(len(FIGURES), _WAVE_TEMPO, rate, tempo)
    means, delays = zip(*FIGURES.values(), strict=True)
    turns = _SWINGS * bars[:, None] - _changing(np.array(delays), bars) / 8.0
    swing = np.sin(2.0 * np.pi * turns) * np.tile(_SWING, 2)  # (T, 4)
    angles = np.tile([0.0, _FORWARD, 0.0, _ELBOW], (len(bars), 2))
    angles[:, 0::4] = swing[:, 0::2] + _changing(np.array(means)[:, None], bars)
    angles[:, 2::4] = swing[:, 1::2]
    posture = kinematics.posture_from_angles(angles)
    return _dance("wave", posture, bars, tuple(FIGURES), rate, tempo)


def conductor(rate: float = 20.0, tempo: float = 1.0) -> Motion:
    """Return a conductor who beats four bars of four.

    The motion is made by hand, not recorded. The right hand beats down, in, out and up, the
    classical pattern, with a rebound after each beat; the left one mirrors it for a bar, gives a
    cue, rises for a crescendo and sinks for a diminuendo. Wrists follow periodic cubic splines at
    96 beats per minute; elbows point down and outward. All numbers are choices (choice).

    Args:
        rate: Postures per second, Hz.
        tempo: Speed relative to 96 beats per minute.

    Returns:
        The motion, with the bars of the left hand as labels.

    Raises:
        BadOptionError: So fast or so coarsely sampled that a bar has no two samples.
    """
    bars = _times(len(BARS), _CONDUCTOR_TEMPO, rate, tempo)
    left = [point for bar in BARS.values() for point in bar]
    hands = (_arm(np.array(way), bars) for way in (left, BEAT * len(BARS)))
    posture = np.stack([*hands], axis=1)  # (T, arm, segment, xyz), as of left arms
    posture[:, 1, :, 1] *= -1.0
    return _dance("conductor", posture.reshape(-1, 12), bars, tuple(BARS), rate, tempo)


def _times(count: int, beats_per_minute: float, rate: float, tempo: float) -> Array:
    """Return the times of the samples of bars, shape (T,), bars."""
    samples = whole_samples(_BEATS * 60.0 / (beats_per_minute * tempo), "bar", rate, tempo)
    return np.arange(count * samples, dtype=np.float64) / samples


def _dance(
    name: str, posture: Array, bars: Array, labels: tuple[str, ...], rate: float, tempo: float
) -> Motion:
    """Return the motion of postures, shape (T, 12), at times, shape (T,), bars, a label each."""
    context = one_hot(bars.astype(int), len(labels))
    return Motion(posture, context, labels, rate, name, f"made by hand: {name}", tempo)


def _changing(values: Array, bars: Array) -> Array:
    """Return values, shape (n, C), one after the other, at times, shape (T,), bars: (T, C)."""
    bar = bars.astype(int)
    share = minimum_jerk((bars - bar) / _CHANGE)[:, None]
    return values[bar - 1] + share * (values[bar] - values[bar - 1])


def _arm(points: Array, bars: Array) -> Array:
    """Return the directions of an arm whose wrist passes points on a closed way.

    Args:
        points: Points at equal times, shape (n, 3), upper arms.
        bars: Times, shape (T,), bars.

    Returns:
        Directions of upper arm and forearm, shape (T, 2, 3). Both being of length 1, the elbow is
        above the middle of the way from shoulder to wrist.
    """
    from scipy.interpolate import CubicSpline  # slow to import

    times = np.arange(len(points) + 1) / (2 * _BEATS)
    wrist = CubicSpline(times, [*points, points[0]], bc_type="periodic")(bars)  # (T, 3)
    square = np.vecdot(wrist, wrist)[:, None]
    side = _ELBOWS_TO - (wrist @ _ELBOWS_TO)[:, None] / square * wrist
    height = np.sqrt(1.0 - 0.25 * square) / np.linalg.norm(side, axis=1, keepdims=True)
    upper_arm = 0.5 * wrist + height * side
    return np.stack([upper_arm, wrist - upper_arm], axis=1)
