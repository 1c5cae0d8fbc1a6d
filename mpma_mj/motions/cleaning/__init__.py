"""Cleaning of recordings: named stages from trajectories with gaps to smooth points of the body."""

from __future__ import annotations

from collections.abc import Callable

from mpma_mj.motions.cleaning.body_points import (
    average_markers,
    lean_torso,
    measure_segments,
    turn_upright,
)
from mpma_mj.motions.cleaning.calibration_pose import cut_calibration_pose
from mpma_mj.motions.cleaning.coordinates import check_coordinates
from mpma_mj.motions.cleaning.filtering import filter_and_resample
from mpma_mj.motions.cleaning.gaps import cut_long_gaps, fill_gaps, refuse_unseen, replace_torso
from mpma_mj.motions.cleaning.jumps import check_ends, repair_jumps
from mpma_mj.motions.cleaning.other_arm import add_other_arm, add_other_shoulder
from mpma_mj.motions.cleaning.outliers import remove_outliers
from mpma_mj.motions.cleaning.pace import check_pace
from mpma_mj.motions.cleaning.proportions import check_proportions
from mpma_mj.motions.cleaning.trajectories import Trajectories, cut_time
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["MARKER_STAGES", "POINT_STAGES", "Stage", "clean"]

Stage = Callable[[Trajectories, ReadingOptions, ImportReport], None]

MARKER_STAGES: tuple[Stage, ...] = (
    cut_time,
    remove_outliers,
    refuse_unseen,
    repair_jumps,
    check_pace,
    cut_long_gaps,
    replace_torso,
    check_coordinates,
    fill_gaps,
)
"""Stages that see markers, in order; after the last one no sample is missing."""

POINT_STAGES: tuple[Stage, ...] = (
    average_markers,
    turn_upright,
    measure_segments,
    check_proportions,
    add_other_shoulder,
    lean_torso,
    add_other_arm,
    cut_calibration_pose,
    check_ends,
    filter_and_resample,
)
"""Stages that see points of the body, in order."""


def clean(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Clean trajectories by all stages, in place.

    Args:
        trajectories: Trajectories by marker; afterwards by point of the body, z up, smooth, at
            the new rate.
        options: How to read the recording.
        report: Every stage adds what it found and did; `mpma motion` prints it.

    Raises:
        MpmaError: A stage refuses the recording, or an option does not fit it.
    """
    for stage in MARKER_STAGES + POINT_STAGES:
        stage(trajectories, options, report)
