"""Frames that repeat, are left out or come in the wrong order, as the pace of all markers shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["check_pace", "exchanged_at_end", "odd_steps"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A step that is so many times its neighbours: a frame repeats, was lost, or two are exchanged.
_ODD = {
    0: "repeats the one before, amid a movement",
    2: "comes a frame too late: one seems to be missing before it",
    -1: "and the one before seem to be exchanged",
}
# Of the neighbours' mean (choice; no step of the public recordings that the results list is odd):
_SAME = 0.3  # by which a step may differ from a multiple of it
_STEADY = 0.4  # by which the neighbours may differ
_MOVING = 0.5  # of the usual step, from which there is a pace
# A step over a lost frame (choices; in those recordings neither a step nor an end is such):
_EVEN = 0.18  # of it, by which that of the two next to it alone may differ
_TWICE = 0.4  # by which it may differ from twice the one that is expected
_BETTER = 0.6  # of what is left without a lost frame may be left with one
_UNLIKE = 2.0  # times as much is left as of any step near
_CLEAR = 1.5  # times what is usually left, from which an expected step is clear
_NEAR = range(3, 9)  # steps away
# Of squared bends at an end: what is left with two frames exchanged, and how unusual they are.
_STRAIGHT, _BENT = 0.2, 4.0
_END = 6  # frames
_AT_ONCE = 1 << 12  # frames


def check_pace(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Warn of odd steps of all markers at once."""
    tracks, frames = list(trajectories.tracks.values()), trajectories.frames
    found: dict[int, list[int]] = {}
    for first in range(0, frames, _AT_ONCE):
        places = np.concatenate([track[first : first + _AT_ONCE + 5] for track in tracks], axis=1)
        for multiple, steps in odd_steps(np.nan_to_num(np.diff(places, axis=0))).items():
            found.setdefault(multiple, []).extend((first + 1 + steps).tolist())
    ends = np.concatenate([np.concatenate([t[:20], t[-20:]]) for t in tracks], axis=1)
    if frames >= 20 and np.isfinite(ends).all():
        first, last = exchanged_at_end(ends[:20]), exchanged_at_end(ends[:-21:-1])
        found[-1] = found.get(-1, []) + [first] * bool(first) + [frames - last] * bool(last)
    for multiple, odd in found.items():
        if odd:
            more = f", as do {len(odd) - 1} more" if len(odd) > 1 else ""
            report.warn(
                f"frame {trajectories.first + odd[0] + 1} {_ODD[multiple]}{more}; frames are"
                " treated as consecutive"
            )


def odd_steps(steps: Array) -> dict[int, NDArray[np.int_]]:
    """Find steps that are none, double or backward, amid a steady motion.

    With m the mean of the steps two before and two after a step s, |s - k m| is small for a
    k of 0 or -1; that of an undamaged motion is 1. A step of exactly 0 between two that
    are much the same is odd at any pace. For k = 2 see `_over_lost_frames`.

    Args:
        steps: From each frame to the next, of all markers, shape (T, D).

    Returns:
        Indices of the steps for each k that there is.
    """
    before, here, after = steps[:-4], steps[2:-2], steps[4:]
    if not len(here):
        return {}
    mean = 0.5 * (before + after)
    pace = np.linalg.norm(mean, axis=1)
    usual = np.median(np.linalg.norm(steps, axis=1))
    steady = np.linalg.norm(before - after, axis=1) < _STEADY * pace
    steady &= pace > _MOVING * usual
    odd = {k: steady & (np.linalg.norm(here - k * mean, axis=1) < _SAME * pace) for k in (0, -1)}
    last, next_ = steps[1:-3], steps[3:-1]
    on = np.linalg.norm(last - next_, axis=1) < 0.5 * np.linalg.norm(last + next_, axis=1)
    odd[0] |= on & ~here.any(axis=1)
    odd[2] = _over_lost_frames(steps)
    return {k: np.flatnonzero(mask) + 2 for k, mask in odd.items() if mask.any()}


def _over_lost_frames(steps: Array) -> Mask:
    """Return which steps, shape (T, D), are those over a lost frame, shape (T - 4,).

    A step is expected on the cubic curve through the two before and the two after it, which are
    1.5 and 2.5 frames away where a frame is lost, and else 1 and 2.
    """
    five = np.stack([steps[i : len(steps) - 4 + i] for i in range(5)])
    first, before, here, after, last = five * five.all(axis=0)  # markers that are seen in all
    near, far = before + after, first + last
    twice = 25 / 16 * near - 9 / 16 * far
    left = np.linalg.norm(here - (4 * near - far) / 6, axis=1)
    left_twice = np.linalg.norm(here - twice, axis=1)
    expected = 0.5 * np.linalg.norm(twice, axis=1)
    share = np.sum(here * twice, axis=1) / np.maximum(2.0 * expected**2, np.finfo(float).tiny)
    padded = np.pad(left, _NEAR[-1])
    around = np.max(
        [np.roll(padded, way)[_NEAR[-1] : -_NEAR[-1]] for k in _NEAR for way in (k, -k)], axis=0
    )
    return (
        (np.linalg.norm(twice - near, axis=1) < _EVEN * 2.0 * expected)
        & (np.abs(share - 2.0) < _TWICE)
        & (left_twice < _BETTER * left)
        & (expected > _CLEAR * np.median(left))
        & (left > _UNLIKE * around)
    )


def exchanged_at_end(places: Array) -> int:
    """Return the later of two frames that are exchanged at the beginning, 1 or 2; 0 if none are.

    Args:
        places: Of all markers in the first frames, shape (T, D), T > 16.
    """
    near = max(_bends(places[i : i + _END]) for i in range(3, 11))
    for later in (1, 2):
        order = np.arange(_END)
        order[[later - 1, later]] = later, later - 1
        bends = _bends(places[:_END])
        if bends > _BENT * near and _bends(places[order]) < _STRAIGHT * bends:
            return later
    return 0


def _bends(places: Array) -> float:
    """Return the sum of squared second differences of places, shape (T, D)."""
    return float(np.sum(np.diff(places, n=2, axis=0) ** 2))
