"""From raw markers to clean points: gaps filled, noise filtered, time resampled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError

__all__ = ["CUTOFF", "fill_gaps", "low_pass", "resample"]

Array = NDArray[np.float64]

CUTOFF = 6.0
"""Cut-off frequency of the low-pass filter, Hz: usual for human movement (choice); see
Winter (2009), Biomechanics and Motor Control of Human Movement, 4th ed., §3.4."""


def fill_gaps(
    points: dict[str, Array], rate: float, max_gap: float, where: str
) -> dict[str, Array]:
    """Bridge short gaps by shape-preserving interpolation.

    Args:
        points: Trajectories by name, each shape (T, 3); a gap is NaN.
        rate: Frames per second, Hz.
        max_gap: Longest gap that is bridged, s.
        where: What an error calls the recording.

    Returns:
        The trajectories, without NaN.

    Raises:
        MotionFileError: A point is missing throughout, at the very start or end, or for longer
            than `max_gap`; says which point and which frames.
    """
    return {name: _filled(name, track, rate, max_gap, where) for name, track in points.items()}


def _filled(name: str, track: Array, rate: float, max_gap: float, where: str) -> Array:
    missing = ~np.isfinite(track).all(axis=1)
    if not missing.any():
        return track
    if missing.all():
        raise MotionFileError(
            f"{where}: marker {name} is missing in all {len(track)} frames;"
            " the arms cannot be followed without it"
        )
    edges = np.flatnonzero(np.diff(np.concatenate([[0], missing, [0]])))
    for first, end in edges.reshape(-1, 2):
        frames = f"frames {first + 1} to {end}"
        if first == 0 or end == len(track):
            raise MotionFileError(
                f"{where}: marker {name} is missing in {frames}, at the"
                f" {'start' if first == 0 else 'end'} of the recording, where nothing can be"
                " interpolated; cut these frames off"
            )
        if (end - first) / rate > max_gap:
            raise MotionFileError(
                f"{where}: marker {name} is missing in {frames} ({(end - first) / rate:.2f} s);"
                f" gaps up to {max_gap:g} s are bridged, --max-gap changes that"
            )
    from scipy.interpolate import PchipInterpolator  # slow to import, needed by few runs

    time = np.arange(len(track))
    filled = track.copy()
    filled[missing] = PchipInterpolator(time[~missing], track[~missing])(time[missing])
    return filled


def low_pass(points: Array, rate: float, cutoff: float) -> Array:
    """Filter without delay: Butterworth of second order, forwards and backwards.

    Args:
        points: Trajectories, shape (T, ...).
        rate: Frames per second, Hz.
        cutoff: Cut-off frequency, Hz. From half the rate on there is nothing to remove.

    Returns:
        The filtered trajectories, same shape.
    """
    if cutoff >= 0.5 * rate:
        return points
    from scipy import signal  # slow to import, needed by few runs

    sections = signal.butter(2, cutoff, fs=rate, output="sos")
    padding = min(3 * (2 * len(sections) + 1), len(points) - 1)
    return signal.sosfiltfilt(sections, points, axis=0, padlen=padding)


def resample(points: Array, rate: float, new_rate: float) -> Array:
    """Read trajectories at other times, by cubic interpolation.

    Args:
        points: Trajectories, shape (T, ...), free of what is faster than half of `new_rate`.
        rate: Frames per second that they have, Hz.
        new_rate: Frames per second that are wanted, Hz.

    Returns:
        Trajectories, shape (T', ...), over the same time.
    """
    if new_rate == rate:
        return points
    from scipy.interpolate import CubicSpline  # slow to import, needed by few runs

    count = int(np.floor((len(points) - 1) / rate * new_rate + 1e-9)) + 1
    time = np.arange(count) / new_rate
    if len(points) < 2:
        return points[:count]
    return CubicSpline(np.arange(len(points)) / rate, points, axis=0)(time)
