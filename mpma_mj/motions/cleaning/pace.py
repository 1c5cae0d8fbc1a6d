"""Frames that repeat, are left out or come in the wrong order, as the pace of all markers shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["check_pace", "odd_steps"]

Array = NDArray[np.float64]

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
_AT_ONCE = 1 << 12  # frames


def check_pace(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Warn of odd steps of all markers at once."""
    tracks = list(trajectories.tracks.values())
    found: dict[int, list[int]] = {}
    for first in range(0, trajectories.frames, _AT_ONCE):
        places = np.concatenate([track[first : first + _AT_ONCE + 5] for track in tracks], axis=1)
        for multiple, steps in odd_steps(np.nan_to_num(np.diff(places, axis=0))).items():
            found.setdefault(multiple, []).extend((first + 1 + steps).tolist())
    for multiple, frames in found.items():
        more = f", as do {len(frames) - 1} more" if len(frames) > 1 else ""
        report.warn(
            f"frame {trajectories.first + frames[0] + 1} {_ODD[multiple]}{more}; frames are treated"
            " as consecutive"
        )


def odd_steps(steps: Array) -> dict[int, NDArray[np.int_]]:
    """Find steps that are none, double or backward, amid a steady motion.

    With m the mean of the steps two before and two after a step s, |s - k m| is small for a
    k of 0, 2 or -1; that of an undamaged motion is 1. A step of exactly 0 between two that
    are much the same is odd at any pace.

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
    odd = {k: steady & (np.linalg.norm(here - k * mean, axis=1) < _SAME * pace) for k in _ODD}
    last, next_ = steps[1:-3], steps[3:-1]
    on = np.linalg.norm(last - next_, axis=1) < 0.5 * np.linalg.norm(last + next_, axis=1)
    odd[0] |= on & ~here.any(axis=1)
    return {k: np.flatnonzero(mask) + 2 for k, mask in odd.items() if mask.any()}
