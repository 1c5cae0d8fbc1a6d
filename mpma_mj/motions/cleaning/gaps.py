"""Gaps, frames in which a marker was not seen: filled, cut off, or refused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError, placeholder
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS, has_trunk
from mpma_mj.motions.cleaning.trajectories import Trajectories, missing
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups
from mpma_mj.motions.options import ReadingOptions

__all__ = ["cut_long_gaps", "fill_gaps", "interpolate", "refuse_unseen", "replace_torso", "runs"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_UNKNOWN = 0.5  # s: in a longer gap any motion is possible (choice)
_SHORTEST = 0.25  # s: a shorter stretch is no motion (choice)


def refuse_unseen(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Refuse arms of which a marker, or a point with all its markers, is never seen.

    Raises:
        MotionFileError: There is one; names it, and how to do without it if that is possible.
    """
    where, groups = trajectories.where, trajectories.groups
    for name in trajectories.arm_markers:
        if not trajectories.seen([name]).any():
            raise MotionFileError(
                f"{where}: marker {name} is missing in all {trajectories.frames} frames",
                remedy=_without(name, trajectories) or "the arms cannot be followed without it",
            )
    for point in trajectories.arm_points:
        if not trajectories.seen(groups[point]).any():
            raise MotionFileError(
                f"{where}: {' and '.join(groups[point])} are never seen together, but the"
                f" {point.replace('_', ' ')} needs both"
            )


def cut_long_gaps(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Refuse long gaps of the arms, or keep the `longest` stretch without; cut gaps at the ends.

    Raises:
        MotionFileError: A gap is longer than `max_gap`; the message lists remedies.
    """
    gaps = [
        (*gap, name)
        for name in trajectories.arm_markers
        for gap in _long_gaps(trajectories, name, options.max_gap)
    ]
    if gaps:
        _cut_to_longest(trajectories, gaps, options, report)
    _trim(trajectories, trajectories.arm_markers, "arms", report)


def replace_torso(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Do without torso markers that are missing for too long; cut gaps at the ends.

    Raises:
        MotionFileError: At no time all markers that are left are seen.
    """
    groups = trajectories.groups
    names = [name for point in TORSO_POINTS for name in groups.get(point, ())]
    removed = {name for name in names if _long_gaps(trajectories, name, options.max_gap)}
    if removed or not trajectories.seen(names).any():
        _replace_torso(trajectories, names, removed, report)
    _trim(trajectories, [*trajectories.tracks], "arms and the torso", report)


def fill_gaps(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Fill all gaps that are left."""
    rate = trajectories.rate
    for name, track in trajectories.tracks.items():
        gaps = runs(missing(track))
        if not gaps:
            continue
        in_file = [(trajectories.first + first, trajectories.first + end) for first, end in gaps]
        report.gaps[name] = [(first / rate, end / rate) for first, end in in_file]
        first, end = max(in_file, key=lambda gap: gap[1] - gap[0])
        seconds = (end - first) / rate
        if seconds > _UNKNOWN:
            report.warn(
                f"{name} is bridged over {seconds:.2f} s from frame {first + 1} on: the motion"
                " there is a guess"
            )
        report.note(
            f"{name}: {_count(sum(e - f for f, e in gaps), 'missing sample')} bridged in"
            f" {_count(len(gaps), 'gap')}, the longest frames {first + 1} to {end}"
            f" ({seconds:.2f} s)"
        )
        interpolate(track)


def interpolate(track: Array) -> None:
    """Fill gaps in place, by shape-preserving cubic interpolation (PCHIP).

    Args:
        track: Trajectory, shape (T, 3), NaN where not seen, seen in the first and last frame.
    """
    from scipy.interpolate import PchipInterpolator  # slow to import, needed by few runs

    gone = missing(track)
    for first, end in runs(gone):
        # Its slopes depend on two samples at either side of the gap.
        near = np.flatnonzero(~gone[max(0, first - 3) : end + 3]) + max(0, first - 3)
        track[first:end] = PchipInterpolator(near, track[near])(np.arange(first, end))


def runs(mask: Mask) -> list[tuple[int, int]]:
    """Return the stretches in which a mask is true, each from its first frame to past its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]


def _long_gaps(trajectories: Trajectories, name: str, max_gap: float) -> list[tuple[int, int]]:
    """Return the gaps of a marker that are longer than `max_gap`, s."""
    limit = max_gap * trajectories.rate + 1e-6
    return [run for run in runs(missing(trajectories.tracks[name])) if run[1] - run[0] > limit]


def _trim(
    trajectories: Trajectories, names: Sequence[str], what: str, report: ImportReport
) -> None:
    """Cut off ends at which a marker is missing: there is nothing to interpolate between.

    Raises:
        MotionFileError: At no time all of the markers are seen.
    """
    first, end = _trimmed((0, trajectories.frames), trajectories.seen(names))
    if end <= first:
        raise MotionFileError(
            f"{trajectories.where}: the markers of the {what} are never all seen at once; record"
            " it again"
        )
    last = trajectories.frames - end
    if first or last:
        report.note(
            f"cut {_count(first, 'frame')} at the start and {last} at the end, where markers of"
            f" the {what} are missing"
        )
        trajectories.cut(first, end)


def _without(name: str, trajectories: Trajectories) -> str:
    """Return how to do without a marker of a point that has others; "" if it has none."""
    for point in trajectories.arm_points:
        group = trajectories.groups[point]
        others = [other for other in group if other != name]
        if name in group and others:
            mapping = placeholder("map", f'"{point}={"+".join(others)}"')
            return f"do without it with {mapping}"
    return ""


def _cut_to_longest(
    trajectories: Trajectories,
    gaps: list[tuple[int, int, str]],
    options: ReadingOptions,
    report: ImportReport,
) -> None:
    """Keep the longest stretch without the gaps, if `longest` is set and it is possible."""
    rate, offset, frames = trajectories.rate, trajectories.first, trajectories.frames
    clean = np.ones(frames, bool)
    for first, end, _ in gaps:
        clean[first:end] = False
    seen = trajectories.seen(trajectories.arm_markers)
    stretches = [_trimmed(run, seen) for run in runs(clean)]
    begin, stop = max(stretches, key=lambda run: run[1] - run[0], default=(0, 0))
    usable = (stop - begin) / rate >= _SHORTEST
    kept = f"frames {offset + begin + 1} to {offset + stop}, {(stop - begin) / rate:.2f} s"
    first, end, name = min(gaps)
    how = " or far outside the body" if name in trajectories.outliers else ""
    described = (
        f"marker {name} is missing{how} in frames {offset + first + 1} to {offset + end}"
        f" ({(end - first) / rate:.2f} s)"
    )
    if len(gaps) > 1:
        verb = "is" if len(gaps) == 2 else "are"
        described += f" and there {verb} {_count(len(gaps) - 1, 'more such gap')}"
    if options.longest and usable:
        trajectories.cut(begin, stop)
        report.note(
            f"kept {kept}, the longest stretch without long gaps, as requested: {described}"
        )
        return
    most = max(end - first for first, end, _ in gaps) / rate
    inside = bool(seen.any()) and all(first > 0 and end < frames for first, end, _ in gaps)
    ways = [f"bridge them with {{max_gap={np.ceil(100 * most - 1e-6) / 100:g}}}"] * inside
    ways += [f"keep the longest clean stretch ({kept}) with {{longest}}"] * usable
    if most > _UNKNOWN:
        ways.reverse()
    raise MotionFileError(
        f"{trajectories.where}: {described}, longer than {options.max_gap:g} s",
        remedy=", or ".join(ways) or "too little would be left; record it again",
    )


def _replace_torso(
    trajectories: Trajectories, names: list[str], removed: set[str], report: ImportReport
) -> None:
    """Take the torso from other markers, or as upright where too few are left."""
    gaps = {name: runs(missing(trajectories.tracks[name])) for name in names}
    longest = {n: max((end - first for first, end in gaps[n]), default=0) for n in names}
    name = max(names, key=longest.__getitem__)
    missed = f"torso marker {name} is missing for up to {longest[name] / trajectories.rate:.2f} s"
    others = _other_torso(trajectories, removed)
    if others is None:
        report.warn(f"{missed}; the torso is assumed to be upright, so that bending moves the arms")
        if has_trunk(trajectories.groups):
            pelvis, neck = map(trajectories.mean, TORSO_POINTS)
            seen = ~missing(neck - pelvis)
            trajectories.removed_trunk = (neck - pelvis)[seen] if seen.any() else None
    else:
        used = "; ".join(f"{point} {' + '.join(group)}" for point, group in others.items())
        report.warn(f"{missed}; the torso is computed from other markers: {used}")
    arms = {point: trajectories.groups[point] for point in trajectories.arm_points}
    trajectories.groups = arms | (others or {})
    kept = {name for group in trajectories.groups.values() for name in group}
    trajectories.tracks = {n: track for n, track in trajectories.tracks.items() if n in kept}


def _other_torso(trajectories: Trajectories, removed: set[str]) -> Groups | None:
    """Return torso points without some markers, None if too few are left.

    Of four markers of the pelvis, two in front and two behind, either pair will do; for the
    neck the shoulders.
    """
    groups = trajectories.groups
    if not groups.keys() >= {*ARM_POINTS, *TORSO_POINTS}:
        return None  # of one arm
    pelvis, neck = (groups[point] for point in TORSO_POINTS)
    pelvises = [pelvis, pelvis[2:], pelvis[:2]] if len(pelvis) == 4 else [pelvis]
    necks = [neck, (*groups["left_shoulder"], *groups["right_shoulder"])]
    found: Groups = {}
    for point, choices in zip(TORSO_POINTS, (pelvises, necks), strict=True):
        group = next((group for group in choices if not removed & set(group)), None)
        if group is not None:
            found[point] = group
    markers = [name for group in found.values() for name in group]
    return found if len(found) == 2 and trajectories.seen(markers).any() else None


def _trimmed(run: tuple[int, int], seen: Mask) -> tuple[int, int]:
    """Return a stretch from its first to past its last whole frame; (0, 0) if it has none."""
    inside = np.flatnonzero(seen[slice(*run)])
    return (run[0] + int(inside[0]), run[0] + int(inside[-1]) + 1) if len(inside) else (0, 0)


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"
