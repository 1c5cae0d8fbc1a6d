"""Jumps of a marker for a single frame: a wrong match, a flicker, or a wrong number."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length
from mpma_mj.utils.text import listing

__all__ = ["check_ends", "off_at_end", "repair_jumps", "single_frame_jumps", "small_jumps"]

Array = NDArray[np.float64]

# A jump is at least this share of the arm's length, and so many times what is usual (choice): fast
# arms move on, a jump comes back.
_SHARE = 0.1
_USUAL = 15.0
# Smaller ones are so much farther from the curve through their neighbours than all frames near, and
# this much farther than the next two, which are 2/3 as far from theirs because of the jump: on the
# other side, to a share of the jump, which a bend of the path is not (it has 1/2).
_SMALL_SHARE = 0.04
_NEAR, _UNLIKE_NEAR, _SINGLE, _ALIKE = 8, 5.0, 1.3, 0.12
_END_SHARE = 0.005  # of the arm's length, that an end is off
# Curves that show where an end belongs: frames that they fit, their degree, and how many times as
# far as all frames near the end has to be off. The first averages noise, the second bends. Of
# 68,208 beginnings within the public recordings 16 are off, all at flickers of a marker.
_CURVES = ((10, 2, 4.0), (6, 4, 5.0))
_WINDOWS = 14  # places near the end, its own included, that are compared
_END = 3  # frames, which single_frame_jumps cannot compare with both sides
_MOST_LISTED = 5


def single_frame_jumps(track: Array, arm_length: float) -> NDArray[np.int_]:
    """Find the frames in which a marker leaves its path and comes back at once.

    There it is farther from the middle of its neighbours than these are from each other, and
    than the two frames next to it are from the middle of theirs; or it is off a smooth path.

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
    small = small_jumps(track, _SMALL_SHARE * arm_length)
    return np.union1d(np.flatnonzero(far & farthest) + 1, small)


def small_jumps(track: Array, least: float, *, exact: bool = False) -> NDArray[np.int_]:
    """Find the frames that lie off the cubic curve through the four next to them.

    Args:
        track: As for `single_frame_jumps`, shape (T, D).
        least: How far off they are at least.
        exact: Whether the path has no noise, but may have bends, as that of a robot.

    Returns:
        Indices of the frames, in order.
    """
    if len(track) < 5:
        return np.empty(0, int)
    way = track[2:-2] - (4.0 * (track[1:-3] + track[3:-1]) - track[:-4] - track[4:]) / 6.0
    off = np.linalg.norm(way, axis=1)  # NaN next to gaps
    if not np.isfinite(off).any():
        return np.empty(0, int)
    large = off > max(least, _USUAL * float(np.nanmedian(off)))
    known = np.nan_to_num(off)
    found = []
    for i in np.flatnonzero(large[1:-1]) + 1:  # the next two have to be known
        near = np.concatenate(
            [known[max(0, i - _NEAR) : max(0, i - 2)], known[i + 3 : i + _NEAR + 1]]
        ).max(initial=0.0)
        alike = np.linalg.norm(way[[i - 1, i + 1]] + way[i] * 2 / 3, axis=1).max()
        single = (
            alike < _ALIKE * off[i] if exact else off[i] > _SINGLE * known[[i - 1, i + 1]].max()
        )
        if off[i] > _UNLIKE_NEAR * near and single:
            found.append(i + 2)
    return np.array(found, int)


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


def check_ends(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Warn of first and last frames that are off the path, where a filter does not smooth."""
    points = trajectories.tracks
    arm = arm_length(points)
    for order in (1, -1):
        off = {
            name: frame
            for name, track in points.items()
            if (frame := off_at_end(track[::order], arm)) is not None
        }
        if off:
            first = next(iter(off.values()))
            frame = first if order > 0 else trajectories.frames - 1 - first
            report.warn(
                f"in frame {trajectories.first + frame + 1}, at the end of the recording, the"
                f" {', '.join(off).replace('_', ' ')} jumps; correct that frame, or cut it off with"
                " {start} and {end}"
            )


def off_at_end(track: Array, arm_length: float) -> int | None:
    """Return which of the first places of a trajectory is off the curve through the next ones.

    Args:
        track: Trajectory, shape (T, D), without gaps.
        arm_length: As of `single_frame_jumps`.

    Returns:
        Its index; None if there is none.
    """
    # The last such frame: it also puts the curves off on which those before it would have to lie.
    for frame, (fitted, degree, unlike) in itertools.product(reversed(range(_END)), _CURVES):
        part = track[frame : frame + _WINDOWS + fitted]
        if len(part) < _WINDOWS + fitted:
            continue
        powers = np.vander(np.arange(1.0, 1 + fitted), degree + 1)
        weights = np.linalg.pinv(powers)[-1]  # of the places, for the curve at 0
        windows = np.lib.stride_tricks.sliding_window_view(part, 1 + fitted, axis=0)
        off = np.linalg.norm(windows[..., 0] - windows[..., 1:] @ weights, axis=1)
        if off[0] > max(_END_SHARE * arm_length, unlike * off[1:].max()):
            return frame
    return None
