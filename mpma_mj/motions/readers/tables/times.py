"""Times and numbers of frames: what rate they show, and where frames are missing."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.import_report import ImportReport

__all__ = ["Where", "arrangement", "ascend", "continuous", "may_be_times", "rate_of"]

Array = NDArray[np.float64]
Where = Callable[[int], str]
"""Name of a row by its index, such as "line 7"."""

_DRIFT = 0.25  # frames
_UNEVEN, _OFTEN = 0.25, 0.05  # frames that a step is off; share of the steps (choice)
_LOOKED_AT = 4096  # first times, from which the rate and its rounding are estimated
_UNITS_OF_TIME = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
_FASTEST = 1000.0  # Hz that such times are taken to make
_COUNTS = (1.0, 2.0, 3.0)  # steps of numbers of frames; as milliseconds they would make over 300 Hz
_DAYS = 86400.0  # s
_FIRST_DAY = 20_000.0  # days since 1900, that is 1954, after which times in days are dates
_MOST_MISSING = 10  # times as many frames as there are rows: then the numbers are wrong instead
_HALF_A_DAY = 12 * 3600.0  # s, after which clocks start again, or twice that


def continuous(times: Array) -> Array:
    """Return times, shape (T,), s, that go on where a clock starts again at midnight or noon."""
    falls = np.round(-np.diff(times) / _HALF_A_DAY)
    falls[~(falls > 0) | (falls > 2)] = 0.0
    return times + _HALF_A_DAY * np.concatenate([[0.0], np.cumsum(falls)]) if falls.any() else times


def arrangement(
    times: Array | None, numbers: Array | None, where: Where, report: ImportReport
) -> Callable[[Array], Array] | None:
    """Return what puts rows, shape (T, ...), where they belong; None where they are there already.

    Args:
        times: Times of the rows, shape (T,), in any unit, if there are some: they count for more
            than the numbers, which often continue where frames were dropped.
        numbers: Numbers of the frames, shape (T,), if there are some: those that they leave out
            are gaps.
        where: Names a row.
        report: Gets a warning of missing frames.
    """
    if numbers is not None:
        broken = np.flatnonzero(np.isfinite(numbers) & (numbers % 1 != 0))
        if 2 * len(broken) > len(numbers):
            report.warn(
                f"the numbers of frames are not whole, the first at {where(int(broken[0]))}; check"
                " that their column is not exchanged with another"
            )
    if times is not None and ascend(times):
        return _by_times(times, where, report)
    places = None if numbers is None else _places(numbers, where, report)
    return None if places is None else functools.partial(_placed, places=places)


def ascend(times: Array) -> bool:
    """Return whether times, shape (T,), rise throughout."""
    return len(times) > 2 and bool((np.diff(times) > 0).all())


def _by_times(times: Array, where: Where, report: ImportReport) -> Callable[[Array], Array] | None:
    """Return what puts rows, shape (T, ...), to even times; None where they are as they should be.

    Args:
        times: Times of the rows, shape (T,), rising, in any unit.
        where: Names a row.
        report: Gets a warning of missing frames.
    """
    steps = np.diff(times)
    usual = _usual_step(times)
    if _are_uneven(times):
        return functools.partial(_interpolated, times=times, step=usual)
    numbers = np.concatenate([[0.0], np.cumsum(_frames_of(steps, usual))])
    places = _places(numbers, where, report)
    return None if places is None else functools.partial(_placed, places=places)


def _placed(track: Array, *, places: NDArray[np.int_]) -> Array:
    """Return rows, shape (T, ...), with gaps where some are missing."""
    whole = np.full((places[-1] + 1, *track.shape[1:]), np.nan)
    whole[places] = track
    return whole


def _usual_step(times: Array) -> float:
    """Return the mean of the steps that span one frame; a longer one spans missing ones."""
    steps = np.diff(times[:_LOOKED_AT])
    return float(steps[steps < 1.5 * np.median(steps)].mean())


def _frames_of(steps: Array, usual: float) -> Array:
    """Return how many frames each step spans, at least 1."""
    return np.maximum(1, np.round(steps / usual))


def may_be_times(numbers: Array) -> bool:
    """Return whether numbers, shape (T,), rise evenly, but do not count frames."""
    return ascend(numbers) and _usual_step(numbers) not in _COUNTS and not _are_uneven(numbers)


def _are_uneven(times: Array) -> bool:
    """Return whether steps between times often differ from whole frames by more than rounding."""
    steps = np.diff(times)
    usual = _usual_step(times)
    off = np.abs(steps / usual - _frames_of(steps, usual))
    return bool(np.mean(off > _UNEVEN + _resolution(times) / usual) > _OFTEN)


def _resolution(times: Array) -> float:
    """Return the last decimal that times are written with."""
    some = times[:_LOOKED_AT]
    for decimals in range(7):
        unit = 10.0**-decimals
        if np.allclose(some / unit, np.round(some / unit), rtol=0.0, atol=1e-3):
            return unit
    return 0.0


def _interpolated(track: Array, *, times: Array, step: float) -> Array:
    """Return rows, shape (T, ...), at even times, by linear interpolation."""
    even = np.arange(times[0], times[-1] + 1e-3 * step, step)
    columns = track.reshape(len(track), -1).T
    rows = np.stack([np.interp(even, times, column) for column in columns], axis=1)
    return rows.reshape(-1, *track.shape[1:])


def rate_of(
    times: Array, declared: float | None, report: ImportReport, unit: float | None = None
) -> float | None:
    """Return the frame rate that times show.

    Args:
        times: Times of frames, shape (T,).
        declared: The rate that the header declares, Hz, if any.
        report: Gets a warning where the two contradict each other, or frames are unevenly spaced.
        unit: Unit of the times, s, where it is declared.

    Returns:
        Frames per second, Hz: that of the times where they are usable, else the declared one.
    """
    times = times * (unit or 1.0)
    if unit is None and ascend(times) and _are_days(times):
        times = times * _DAYS
    steps = np.diff(times)
    if not ascend(times):
        return _coarse_rate(times, declared, report)
    usual = _usual_step(times)
    rate = 1.0 / usual
    if unit is None and usual in _COUNTS:
        report.warn(
            f"the times rise by {usual:g} a frame, as numbers of frames do; they are not used",
            remedy="{rate_in} gives the rate",
        )
        return declared
    for name, scale in _UNITS_OF_TIME.items() if unit is None else ():
        if rate < 1.0 <= scale * rate <= _FASTEST:
            rate, steps = scale * rate, steps / scale
            report.warn(
                f"the times are read as {name}, which gives {rate:.4g} Hz",
                remedy="{rate_in} overrides it",
            )
            break
    if _are_uneven(times):
        report.warn(
            f"the frames are unevenly spaced; they are interpolated to an even {rate:.4g} Hz"
        )
        return rate  # of the interpolation, whatever the header declares
    # Times are rounded, so that only a clear difference is one.
    if declared is not None and abs(rate - declared) < 0.02 * declared:
        return declared
    if declared is not None:
        report.warn(
            f"the header declares {declared:g} Hz, the times of the frames {rate:.4g} Hz;"
            f" {rate:.4g} Hz is used",
            remedy="{rate_in} overrides it",
        )
    # So are rates, unless that would gain or lose a good part of a frame.
    drift = abs(rate - round(rate)) * float(steps.sum())
    return rate if declared is not None or drift > _DRIFT else float(round(rate))


def _coarse_rate(times: Array, declared: float | None, report: ImportReport) -> float | None:
    """Return the rate where times do not rise from frame to frame."""
    if len(times) < 3:
        return declared
    if not np.isfinite(times).any():
        report.warn(
            "the times are neither numbers nor h:m:s, nor timecodes h:m:s:frames over a whole"
            " second; they are not used",
            remedy="{rate_in} gives the rate",
        )
        return declared
    risen = 1 + np.flatnonzero(np.diff(times) > 0)
    if declared is None and len(risen) and (np.diff(times) >= 0).all():
        # Of the frames between two times that rise, each lasts as long as the others.
        first, last = (risen[0], risen[-1]) if len(risen) > 1 else (0, len(times) - 1)
        rate = float((last - first) / (times[last] - times[first]))
        report.warn(
            f"the times are too coarse to distinguish frames; {rate:.4g} Hz is used, from the"
            " first and last time that rises",
            remedy="{rate_in} overrides it",
        )
        return rate
    report.warn("the column of times does not ascend throughout; it is not used")
    return declared


def _are_days(times: Array) -> bool:
    """Return whether times, shape (T,), are days of a calendar, as spreadsheets count them."""
    seconds = _usual_step(times) * _DAYS
    return times[0] > _FIRST_DAY and 1.0 / _FASTEST <= seconds <= 1.0


def _places(numbers: Array, where: Where, report: ImportReport) -> NDArray[np.int_] | None:
    """Return where each row belongs, from its frame's number, or None for one after another."""
    steps = np.diff(numbers)
    usual = float(np.median(steps)) if len(steps) else 1.0
    even = (steps > 0) & (np.mod(steps, usual or 1.0) == 0)  # not where a number is missing
    if not even.all():
        bad = int(np.argmin(even))
        report.warn(f"the frame numbers jump at {where(bad + 1)}; rows are treated as consecutive")
        return None
    places = ((numbers - numbers[0]) / usual).astype(int)
    missing = places[-1] + 1 - len(places)
    if not missing:
        return None
    if missing > _MOST_MISSING * len(places):
        report.warn(
            f"the frame numbers omit {missing} frames of {places[-1] + 1}; rows are treated as"
            " consecutive"
        )
        return None
    first = int(np.argmax(np.diff(places) > 1))
    report.warn(
        f"{missing} frames are missing, the first after {where(first)}; they are treated as gaps"
    )
    return places
