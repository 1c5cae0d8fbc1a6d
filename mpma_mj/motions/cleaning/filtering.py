"""Low-pass filter and resampling of trajectories."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["anti_alias", "data_cutoff", "filter_and_resample", "looked_at", "low_pass", "resample"]

Array = NDArray[np.float64]

_CUTOFFS = np.arange(2.0, 20.25, 0.5)  # Hz, that are tried
_HUMAN = (4.0, 10.0)  # Hz: lower cuts motion, higher keeps noise (choice, after Winter)
_LONGEST = 60.0  # s that are looked at for a cut-off
_PADDING = 2.0  # periods of the cut-off, in which a filter has settled
_TOP = 0.45  # of the rate: only noise is above, if there is any
_BAND = 0.4  # share of a lower rate up to which resampling lets pass
_AT_ONCE = 4096  # samples
_REACH = 40  # frames


def filter_and_resample(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Filter points and resample them to the requested rate and tempo."""
    points, rate, new_rate = trajectories.tracks, trajectories.rate, trajectories.new_rate
    if options.cutoff is not None:
        cutoff, how = options.cutoff, "as given"
    else:
        start = slice(looked_at(rate))
        arms = np.concatenate([points[name][start] for name in ARM_POINTS], axis=1)
        cutoff, how = data_cutoff(arms, rate), "from the data"
    nothing = cutoff >= 0.5 * rate
    done = "no low-pass filter" if nothing else f"low-pass filter at {cutoff:.3g} Hz, {how}"
    report.note(f"{done}; resampled from {rate:g} Hz to {new_rate:g} Hz")
    played = rate * options.own_tempo  # frames per second of the motion, Hz
    for name in list(points):
        smooth = low_pass(points[name], rate, cutoff)
        points[name] = resample(anti_alias(smooth, played, new_rate), played, new_rate)


def data_cutoff(points: Array, rate: float) -> float:
    """Choose the cut-off frequency by residual analysis.

    The residual R(f) between raw and filtered data falls along a line where only noise is
    removed; extended to f = 0 the line gives the noise within the motion, and the cut-off is
    where R reaches it: Winter (2009), Biomechanics and Motor Control of Human Movement, 4th
    ed., §3.4.4.3. At a low rate that line may be motion as well. Then the noise is taken from what
    is next to half the rate; where the filter would remove more motion than noise, such as from
    an exported motion, which has none, the cut-off is the highest.

    Args:
        points: Trajectories, shape (T, D).
        rate: Frames per second, Hz.

    Returns:
        Cut-off frequency, 4 to 10 Hz.
    """
    tried = _CUTOFFS[_TOP * rate > _CUTOFFS]
    some = points[: looked_at(rate)]
    if len(tried) < 8 or len(some) < rate:
        return _HUMAN[0] if len(tried) < 8 else sum(_HUMAN) / 2
    some = some - some.mean(axis=0)
    residual = np.array([_residual(some, rate, f) for f in tried])
    tail = tried >= 0.6 * tried[-1]
    noise = np.polyval(np.polyfit(tried[tail], residual[tail], 1), 0.0)
    enough = np.flatnonzero(residual <= max(noise, residual[-1]))
    cutoff = float(np.clip(tried[enough[0]], *_HUMAN))
    if tried[tail][0] < _HUMAN[1]:
        top = _residual(some, rate, _TOP * rate, order=6) ** 2 / (0.5 - _TOP)  # per relative band
        removed = _residual(some, rate, cutoff) ** 2
        if top * (0.5 - cutoff / rate) < 0.5 * removed:
            return _HUMAN[1]
    return cutoff


def _residual(points: Array, rate: float, cutoff: float, order: int = 2) -> float:
    """Return the root mean square of what a low-pass filter removes from trajectories, (T, D)."""
    return float(np.sqrt(np.mean((points - low_pass(points, rate, cutoff, order=order)) ** 2)))


def looked_at(rate: float) -> int:
    """Return how many frames at the start `data_cutoff` looks at."""
    return int(_LONGEST * rate)


def low_pass(points: Array, rate: float, cutoff: float, *, order: int = 2) -> Array:
    """Filter without delay: Butterworth, forwards and backwards.

    Args:
        points: Trajectories, shape (T, ...).
        rate: Frames per second, Hz.
        cutoff: Frequency that a quarter of the power is left of, Hz. From half the rate on
            there is nothing to remove.
        order: Order of the filter, of each of the two passes.

    Returns:
        The filtered trajectories, same shape.
    """
    if cutoff >= 0.5 * rate:
        return points
    from scipy import signal  # slow to import, needed by few runs

    sections = signal.butter(order, cutoff, fs=rate, output="sos")
    padding = min(int(_PADDING * rate / cutoff), len(points) - 1)
    return signal.sosfiltfilt(sections, points, axis=0, padlen=padding)


def anti_alias(points: Array, rate: float, new_rate: float) -> Array:
    """Filter out of trajectories, (T, ...), what a lower rate would alias; rates in Hz.

    Of 12 Hz, at a new rate of 20 Hz, 1 % is left.
    """
    return low_pass(points, rate, _BAND * new_rate, order=6) if new_rate < rate else points


def resample(points: Array, rate: float, new_rate: float) -> Array:
    """Return trajectories, (T', ...), at a new rate by cubic interpolation.

    Args:
        points: Trajectories, shape (T, ...), without what the new rate would alias.
        rate: Their frames per second, Hz.
        new_rate: New frames per second, Hz.
    """
    if new_rate == rate:
        return points
    from scipy.interpolate import CubicSpline  # slow to import, needed by few runs

    count = int(np.floor((len(points) - 1) / rate * new_rate + 1e-9)) + 1
    if len(points) < 2:
        return points[:count]
    at = np.arange(count) * (rate / new_rate)  # in frames
    resampled = np.empty((count, *points.shape[1:]))
    # A spline's coefficients take many times the memory of its points; what is farther than
    # some frames away no longer matters (a factor of 0.27 a frame).
    for first in range(0, count, _AT_ONCE):
        times = at[first : first + _AT_ONCE]
        start = max(0, int(times[0]) - _REACH)
        frames = np.arange(start, min(len(points), int(times[-1]) + _REACH + 2))
        resampled[first : first + _AT_ONCE] = CubicSpline(frames, points[frames])(times)
    return resampled
