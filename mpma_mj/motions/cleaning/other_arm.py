"""The other arm of a recording that shows one arm only."""

from __future__ import annotations

from collections.abc import Container

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import forward, segments, trunk
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["add_other_arm", "add_other_shoulder"]

Array = NDArray[np.float64]

_ENDS = {"upper arm": "elbow", "forearm": "wrist"}
_BREADTH = 0.65  # of the shoulders, in lengths of the arm; postures do not depend on it


def add_other_shoulder(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Add the shoulder that is not recorded, opposite to the known one.

    Raises:
        MotionFileError: The shoulder lies above the point that shows the middle of the torso.
    """
    points = trajectories.tracks
    side = _known_side(points)
    if side is None:
        if options.other_arm is not None:
            report.warn("both arms are recorded", remedy="{other_arm} is of no use here")
        return
    across = _across(points, side, report)
    if not np.linalg.norm(across, axis=1).min() > 0.0:
        raise MotionFileError(
            f"{trajectories.where}: the {side} shoulder lies straight above the middle of the"
            " torso, which has to show where its other side is",
            remedy="name another point with {map}",
        )
    points.setdefault(f"{_other(side)}_shoulder", points[f"{side}_shoulder"] + across)


def add_other_arm(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Add the arm that is not recorded: it hangs along the trunk, or mirrors the known one."""
    points = trajectories.tracks
    side = _known_side(points)
    if side is None:
        return
    up, across = trunk(points), np.cross(forward(points), trunk(points))
    up, mirror = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (up, across))
    place = points[f"{_other(side)}_shoulder"]
    for name in ("upper arm", "forearm"):
        way = segments(points)[f"{side} {name}"]
        if options.other_arm == "hang":
            way = -up * np.median(np.linalg.norm(way, axis=1))
        else:
            way = way - 2.0 * np.sum(way * mirror, axis=1, keepdims=True) * mirror
        place = place + way
        points[f"{_other(side)}_{_ENDS[name]}"] = place
    done = "hangs" if options.other_arm == "hang" else f"is the mirror image of the {side} one"
    report.note(f"the {_other(side)} arm is not recorded and {done}, as requested")


def _known_side(points: Container[str]) -> str | None:
    """Return the side of the only arm that is whole, None if both are."""
    whole = [side for side in SIDES if f"{side}_wrist" in points]
    return whole[0] if len(whole) == 1 else None


def _other(side: str) -> str:
    return SIDES[1 - SIDES.index(side)]


def _across(points: dict[str, Array], side: str, report: ImportReport) -> Array:
    """Return the way from the known to the other shoulder, perpendicular to the trunk, (T, 3)."""
    other = _other(side)
    shoulder, up = points[f"{side}_shoulder"], trunk(points)
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
        front = np.mean(reach * [1.0, 1.0, 0.0], axis=0)
        front /= np.linalg.norm(front) or 1.0
        left = np.array([-front[1], front[0], 0.0]) if front.any() else np.eye(3)[1]
        length = _BREADTH * np.median(np.linalg.norm(reach, axis=1))
        across = np.tile(left * (length if other == "left" else -length), (len(shoulder), 1))
    along = np.sum(across * up, axis=1) / np.sum(up * up, axis=1)
    return across - along[:, None] * up
