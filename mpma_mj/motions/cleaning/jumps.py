"""Jumps of a marker for a single frame: a wrong match, or a flicker."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length
from mpma_mj.utils.text import listing

__all__ = ["repair_jumps", "single_frame_jumps"]

Array = NDArray[np.float64]

# A jump is at least this share of the arm's length, and so many times what is usual (choice): fast
# arms move on, a jump comes back.
_SHARE = 0.1
_USUAL = 15.0
_MOST_LISTED = 5


def single_frame_jumps(track: Array, arm_length: float) -> NDArray[np.int_]:
    """Find the frames in which a marker leaves its path and comes back at once.

    There it is farther from the middle of its neighbours than these are from each other, and
    than the two frames next to it are from the middle of theirs.

    Args:
        track: Trajectory, shape (T, 3), NaN where not seen.
        arm_length: Upper arm and forearm, in the unit of the trajectory.

    Returns:
        Indices of the frames, in order.
    """
    if len(track) < 3:
        return np.empty(0, int)
    before, here, after = track[:-2], track[1:-1], track[2:]
    away = np.linalg.norm(here - 0.5 * (before + after), axis=1)  # NaN next to gaps
    onward = np.linalg.norm(after - before, axis=1)
    if not np.isfinite(away).any():
        return np.empty(0, int)
    usual = float(np.nanmedian(away))
    padded = np.pad(np.nan_to_num(away), 1)
    farthest = away >= np.maximum(padded[:-2], padded[2:])
    far = (away > _SHARE * arm_length) & (away > onward) & (away > _USUAL * usual)
    return np.flatnonzero(far & farthest) + 1


def repair_jumps(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Make gaps of single-frame jumps with `repair`, else warn of them."""
    arm = arm_length({point: trajectories.mean(point) for point in trajectories.arm_points})
    found = {
        name: frames
        for name in trajectories.tracks
        if len(frames := single_frame_jumps(trajectories.tracks[name], arm))
    }
    if not found:
        return
    count = sum(map(len, found.values()))
    jumps = f"{count} single-frame jump{'s' * (count != 1)}"
    listed = "; ".join(
        f"{name} in frame {listing((trajectories.first + frames + 1).tolist(), _MOST_LISTED)}"
        for name, frames in found.items()
    )
    if not options.repair:
        report.warn(f"{jumps} ({listed})", remedy="{repair} bridges them")
        return
    for name, frames in found.items():
        trajectories.tracks[name][frames] = np.nan
    report.note(f"{jumps} bridged ({listed})")
