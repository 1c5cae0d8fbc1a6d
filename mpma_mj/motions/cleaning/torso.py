"""The torso of a recording whose markers of pelvis or neck are missing for long."""

from __future__ import annotations

from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS
from mpma_mj.motions.cleaning.gaps import long_gaps, runs, trim
from mpma_mj.motions.cleaning.trajectories import Trajectories, missing
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.marker_sets import Groups
from mpma_mj.motions.options import ReadingOptions

__all__ = ["replace_torso"]


def replace_torso(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Do without torso markers that are missing for too long; cut gaps at the ends.

    Raises:
        MotionFileError: At no time all markers that are left are seen.
    """
    groups = trajectories.groups
    names = [name for point in TORSO_POINTS for name in groups.get(point, ())]
    lost = {name for name in names if long_gaps(trajectories, name, options.max_gap)}
    if lost or not trajectories.seen(names).any():
        _replace(trajectories, names, lost, report)
    trim(trajectories, [*trajectories.tracks], "arms and the torso", report)


def _replace(
    trajectories: Trajectories, names: list[str], lost: set[str], report: ImportReport
) -> None:
    """Take the torso from other markers, or as upright where too few are left."""
    gaps = {name: runs(missing(trajectories.tracks[name])) for name in names}
    longest = {n: max((end - first for first, end in gaps[n]), default=0) for n in names}
    name = max(names, key=longest.__getitem__)
    missed = f"torso marker {name} is missing for up to {longest[name] / trajectories.rate:.2f} s"
    others = _others(trajectories, lost)
    if others is None:
        report.warn(
            f"{missed}; the torso is taken as upright instead, so that a bend moves the arms"
        )
        pelvis, neck = map(trajectories.mean, TORSO_POINTS)
        seen = ~missing(neck - pelvis)
        trajectories.lost_trunk = (neck - pelvis)[seen] if seen.any() else None
    else:
        used = "; ".join(f"{point} {' + '.join(group)}" for point, group in others.items())
        report.warn(f"{missed}; the torso is taken from others: {used}")
    arms = {point: trajectories.groups[point] for point in ARM_POINTS}
    trajectories.groups = arms | (others or {})
    kept = {name for group in trajectories.groups.values() for name in group}
    trajectories.tracks = {n: track for n, track in trajectories.tracks.items() if n in kept}


def _others(trajectories: Trajectories, lost: set[str]) -> Groups | None:
    """Return torso points without some markers, None if too few are left.

    Of four markers of the pelvis, two in front and two behind, either pair will do; for the
    neck the shoulders.
    """
    groups = trajectories.groups
    pelvis, neck = (groups[point] for point in TORSO_POINTS)
    pelvises = [pelvis, pelvis[2:], pelvis[:2]] if len(pelvis) == 4 else [pelvis]
    necks = [neck, (*groups["left_shoulder"], *groups["right_shoulder"])]
    found: Groups = {}
    for point, choices in zip(TORSO_POINTS, (pelvises, necks), strict=True):
        group = next((group for group in choices if not lost & set(group)), None)
        if group is not None:
            found[point] = group
    markers = [name for group in found.values() for name in group]
    return found if len(found) == 2 and trajectories.seen(markers).any() else None
