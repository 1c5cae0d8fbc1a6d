"""Proportions that no body has: columns, names or numbers of a file are then exchanged or wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS, has_trunk, segments, trunk
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["check_proportions"]

Array = NDArray[np.float64]

# Choices, beside what the public recordings have that the results list.
_MOST_VARIED = 0.1  # of a length; skin markers make 4 %
_UNLIKE = 1.25  # times as far as on the other side; 1.18
_SLANTED = 20.0  # degrees from a right angle between trunk and shoulders; 4
_LOWEST = 0.6  # of the way from pelvis to neck, at which shoulders lie; 0.9


def check_proportions(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Warn of lengths that vary or differ between left and right, and of an impossible torso."""
    points = trajectories.tracks
    lines = segments(points)
    if points.keys() >= set(ARM_POINTS):
        lines["line between the shoulders"] = points["left_shoulder"] - points["right_shoulder"]
    if has_trunk(points):
        lines["trunk"] = trunk(points)
    for name, vectors in lines.items():
        length = np.linalg.norm(vectors, axis=1)
        varies = length.std() / length.mean()
        if varies > _MOST_VARIED and not trajectories.recording.from_pictures:
            report.warn(
                f"the {name}'s length varies by {100 * varies:.0f} %: one of its markers is"
                " misplaced for part of the time"
            )
    if points.keys() >= set(ARM_POINTS):
        _compare_sides(points, report)
        if has_trunk(points):
            _check_torso(points, report)


def _compare_sides(points: dict[str, Array], report: ImportReport) -> None:
    """Warn of points that are much farther from each other than on the other side."""
    for start, end in (("neck", "shoulder"), ("shoulder", "elbow"), ("elbow", "wrist")):
        if start == "neck" and not has_trunk(points):
            continue
        apart = {
            side: points[f"{side}_{end}"] - points["neck" if start == "neck" else f"{side}_{start}"]
            for side in SIDES
        }
        usual = {side: np.median(np.linalg.norm(way, axis=1)) for side, way in apart.items()}
        near, far = sorted(SIDES, key=lambda side: usual[side])
        if usual[far] > _UNLIKE * usual[near]:
            ratio = usual[far] / max(usual[near], np.finfo(float).tiny)
            report.warn(
                f"{start} and {end} are {ratio:.3g} times as far apart on the {far} as on the"
                f" {near}: markers or their coordinates are misplaced or exchanged"
            )


def _check_torso(points: dict[str, Array], report: ImportReport) -> None:
    """Warn of shoulders that are not across the upper end of the trunk."""
    way, length = trunk(points), np.linalg.norm(trunk(points), axis=1)
    left, right = points["left_shoulder"], points["right_shoulder"]
    across = left - right
    cosine = np.sum(across * way, axis=1) / (np.linalg.norm(across, axis=1) * length)
    angle = float(np.degrees(np.arccos(np.median(cosine))))
    if abs(angle - 90.0) > _SLANTED:
        report.warn(
            f"the line between the shoulders and the trunk make an angle of {angle:.0f}°: markers"
            " of the torso or their coordinates are misplaced or exchanged"
        )
    middle = 0.5 * (left + right) - points["pelvis"]
    height = float(np.median(np.sum(middle * way, axis=1) / length**2))
    if height < _LOWEST:
        report.warn(
            f"the shoulders lie at {height:.2g} of the way from pelvis to neck: markers of the"
            " torso or their coordinates are misplaced or exchanged"
        )
