"""Calibration pose before a motion, such as a T-pose, and the ramp out of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.body import segments
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["calibration_frames", "cut_calibration_pose"]

Array = NDArray[np.float64]

_FASTER_THAN_HUMAN = 25.0  # rad/s; recorded dances reach 15 (choice)
_FAR = 0.15  # rad from one frame to the next: farther than noise (choice)
_SUDDEN = 0.25  # share of that speed at which human arms would already have been (choice)
_STILL = 0.35  # rad: more than a T-pose sways (choice)
_LATEST = 3.0  # s that a pose is held at most (choice)
_RAMP = 0.25  # s that a ramp lasts at most (choice)
_AFTER = 1.0  # s after it, which show how steady the motion is (choice)
_UNSTEADY = 3.0  # times as much as in that second (choice)


def cut_calibration_pose(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Cut off the frames before the motion itself."""
    count = calibration_frames(trajectories.tracks, trajectories.rate)
    if count:
        frames_cut = "the first frame is" if count == 1 else f"the first {count} frames are"
        if trajectories.first:
            frames_cut = f"frames {trajectories.first + 1} to {trajectories.first + count} are"
        report.warn(f"{frames_cut} cut: a calibration pose")
        trajectories.cut(count, trajectories.frames)


def calibration_frames(points: dict[str, Array], rate: float) -> int:
    """Count the frames before the motion itself.

    They end where arms leave their first pose, from one frame to the next, faster than any human
    arm, stay so for up to a quarter of a second, and do not come back at once, as jumps do. A ramp
    that runs out at lower speed lasts, in the same quarter of a second, while speeds change from
    frame to frame by far more than in the second after it.

    Args:
        points: The points of `body.ARM_POINTS`, each shape (T, 3), without gaps.
        rate: Frames per second, Hz.

    Returns:
        Number of frames to leave out.
    """
    arms = segments(points).values()
    step = np.max([_angles(arm[1:], arm[:-1]) for arm in arms], axis=0)
    away = np.max([_angles(arm[1:], arm[:1]) for arm in arms], axis=0)  # from the first pose
    fast = np.flatnonzero((step * rate > _FASTER_THAN_HUMAN) & (step > _FAR))
    if not len(fast) or fast[0] > _LATEST * rate:
        return 0
    first = int(fast[0])
    left_suddenly = first == 0 or (
        step[first - 1] < _SUDDEN * step[first] and (away[:first] < _STILL).all()
    )
    latest = first + max(1, round(_RAMP * rate))
    end = int(fast[fast < latest][-1]) + 1
    change = np.abs(np.diff(step))
    usual = np.max(change[latest : latest + round(_AFTER * rate)], initial=0.0)
    if usual:
        unsteady = np.flatnonzero(change[end:latest] > _UNSTEADY * usual)
        end += int(np.max(unsteady, initial=-1)) + 1
    stays_away = (away[end - 1 : end + 2] > _STILL).all() and end < len(step)
    return end if left_suddenly and stays_away else 0


def _angles(vectors: Array, others: Array) -> Array:
    """Return the angles between vectors, shape (N, 3), and others, (N, 3) or (1, 3): (N,), rad."""
    lengths = np.linalg.norm(vectors, axis=1) * np.linalg.norm(others, axis=1)
    return np.arccos(np.clip(np.sum(vectors * others, axis=1) / lengths, -1.0, 1.0))
