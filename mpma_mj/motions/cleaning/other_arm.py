"""The other arm of a recording that shows one arm only."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS, trunk
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["add_other_arm"]

Array = NDArray[np.float64]

_BREADTH = 0.65  # of the shoulders, in lengths of the arm; postures do not depend on it


def add_other_arm(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Add the arm that is not recorded: hanging along the trunk, or the known arm's mirror image.

    Raises:
        MotionFileError: The shoulder lies above the point that shows the middle of the torso.
    """
    points = trajectories.tracks
    if all(point in points for point in ARM_POINTS):
        if options.other_arm is not None:
            report.warn("both arms are recorded", remedy="{other_arm} is of no use here")
        return
    side, other = SIDES if "left_wrist" in points else SIDES[::-1]
    joints = [points[f"{side}_{joint}"] for joint in ("shoulder", "elbow", "wrist")]
    up = trunk(points)
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    across = _across(points, side, up, report)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    if not length.min() > 0.0:
        raise MotionFileError(
            f"{trajectories.where}: the {side} shoulder lies straight above the middle of the"
            " torso, which has to show where its other side is",
            remedy="name another point with {map}",
        )
    mirror = across / length
    shoulder = points.setdefault(f"{other}_shoulder", joints[0] + across)
    ways = [end - start for start, end in itertools.pairwise(joints)]
    for name, way in zip(("elbow", "wrist"), ways, strict=True):
        if options.other_arm == "hang":
            way = -up * np.median(np.linalg.norm(way, axis=1))
        else:
            way = way - 2.0 * np.sum(way * mirror, axis=1, keepdims=True) * mirror
        shoulder = points[f"{other}_{name}"] = shoulder + way
    done = "hangs" if options.other_arm == "hang" else f"is the mirror image of the {side} one"
    report.note(f"the {other} arm is not recorded and {done}, as requested")


def _across(points: dict[str, Array], side: str, up: Array, report: ImportReport) -> Array:
    """Return the way from the known to the other shoulder, perpendicular to the trunk, (T, 3)."""
    other = SIDES[1 - SIDES.index(side)]
    shoulder = points[f"{side}_shoulder"]
    middle = next((points[point] for point in ("neck", "pelvis") if point in points), None)
    if f"{other}_shoulder" in points:
        across = points[f"{other}_shoulder"] - shoulder
    elif middle is not None:
        across = 2.0 * (middle - shoulder)
    else:
        report.warn(
            "no point between the shoulders is recognised; the torso is assumed to face where the"
            " wrist points on average",
            remedy='name one with {map="neck=…"}',
        )
        reach = points[f"{side}_wrist"] - shoulder
        forward = np.mean(reach * [1.0, 1.0, 0.0], axis=0)
        forward /= np.linalg.norm(forward) or 1.0
        left = np.array([-forward[1], forward[0], 0.0]) if forward.any() else np.eye(3)[1]
        length = _BREADTH * np.median(np.linalg.norm(reach, axis=1))
        across = np.tile(left * (length if other == "left" else -length), (len(shoulder), 1))
    return across - np.sum(across * up, axis=1, keepdims=True) * up
