"""Points of the body from cleaned markers: averaged, turned upright, and measured."""

from __future__ import annotations

import numpy as np

from mpma_mj.motions.body import check_segments, forward, has_trunk, segments, trunk
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.marker_sets import half_pelvis
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import (
    arm_length,
    find_unit,
    find_up,
    refuse_pictures,
    turn_z_up,
)
from mpma_mj.motions.readers.recording import UNITS

__all__ = ["average_markers", "lean_torso", "measure_segments", "turn_upright"]

# Angle at the neck from the middle of the pelvis to its front or back markers: 10.5° to 16°, median
# 12°, on the whole pelvises of five public recordings (two of Qualisys, HDM05, ISB, Vicon).
_HALF_PELVIS = np.radians(12.0)


def average_markers(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Replace markers by the points of the body that they show."""
    uses = [name for group in trajectories.groups.values() for name in group]
    points = {}
    for point, group in trajectories.groups.items():
        points[point] = trajectories.mean(point)
        for name in group:  # long recordings: a marker is dropped after its last use
            uses.remove(name)
            if name not in uses:
                del trajectories.tracks[name]
    trajectories.tracks = points


def turn_upright(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Turn points so that z is up, and mirror them if their axes are left-handed.

    Raises:
        MotionFileError: Nothing shows which axis is up, the points are those of a picture, or they
            show no arms.
    """
    points, where = trajectories.tracks, trajectories.where
    from_pictures = trajectories.recording.from_pictures
    if options.unit is None and not from_pictures:
        refuse_pictures(points, where)
    declared = trajectories.recording.up
    shown = trajectories.removed_trunk
    up = find_up(points, declared, options.up, where, report, shown, trajectories.others)
    for name in list(points):
        points[name] = turn_z_up(points[name], up)
        if options.left_handed:
            points[name] = points[name] * [1.0, -1.0, 1.0]
    if options.left_handed:
        report.note("left-handed axes, as given: mirrored")
    if not from_pictures:  # in which segments may well have no length
        check_segments(points, where, trajectories.first)


def lean_torso(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Turn the trunk to where it would be if the markers at both ends of the pelvis were known."""
    points = trajectories.tracks
    end = half_pelvis(trajectories.groups.get("pelvis", ()))
    if end is None or not has_trunk(points):
        return
    way, front = trunk(points), forward(points)
    length = np.linalg.norm(way, axis=1, keepdims=True)
    sine = np.sin(_HALF_PELVIS) * (1.0 if end == "front" else -1.0)
    points["pelvis"] = points["neck"] - np.cos(_HALF_PELVIS) * way - sine * length * front
    report.warn(
        f"only the {end} of the pelvis is known: the torso is turned by"
        f" {np.degrees(_HALF_PELVIS):.0f}°, for half the depth of a pelvis, which may be off by 4°"
    )


def measure_segments(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Report the unit, and mean and deviation of the segments' lengths."""
    points, declared = trajectories.tracks, trajectories.recording.unit
    given = None if options.unit is None else UNITS[options.unit]
    unit = find_unit(arm_length(points), declared, given, report)
    report.metric = unit is not None
    for name, vectors in segments(points).items():
        length = np.linalg.norm(vectors, axis=1) * (unit or 1.0)
        report.lengths[name] = (float(length.mean()), float(length.std()))
