"""Points of the body from cleaned markers: averaged, turned upright, and measured."""

from __future__ import annotations

import numpy as np

from mpma_mj.motions.body import check_segments, segments
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length, find_unit, find_up, turn_z_up
from mpma_mj.motions.readers.recording import UNITS

__all__ = ["average_markers", "measure_segments", "turn_upright"]

_MOST_VARIED = 0.15  # of a segment's length; skin markers make 3 % (choice)


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
    """Turn points so that z is up.

    Raises:
        MotionFileError: Nothing shows which axis is up, or the points show no arms.
    """
    points, where = trajectories.tracks, trajectories.where
    declared = trajectories.recording.up
    up = find_up(points, declared, options.up, where, report, trajectories.removed_trunk)
    for name in list(points):
        points[name] = turn_z_up(points[name], up)
    check_segments(points, where, trajectories.first)


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
        varies = length.std() / length.mean()
        if varies > _MOST_VARIED:
            report.warn(
                f"the {name}'s length varies by {100 * varies:.0f} %: one of its markers is"
                " misplaced for part of the time"
            )
