"""From raw trajectories to whole ones: what is missing is bridged, cut away, or refused."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError, placeholder
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS
from mpma_mj.motions.cleaning.gaps import fill_gaps, missing, runs
from mpma_mj.motions.cleaning.jumps import single_frame_jumps
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length
from mpma_mj.motions.readers.recording import Tracks

__all__ = ["Cleaner"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_INVENTED = 0.5  # s: in a longer bridge there may have been any movement (choice)
_MOST_LISTED = 5
_SHORTEST = 0.25  # s: a shorter stretch is no movement (choice)


class Cleaner:
    """Trajectories on their way to being whole.

    Attributes:
        tracks: Trajectories by marker, each shape (T, 3), NaN where not seen.
        groups: Which markers show which point of the body.
        first: Index of their first frame in the file.
        lost_trunk: Ways from pelvis to neck, shape (N, 3), of frames in which both are seen, if
            they are seen too rarely to be a point.
        gaps: For each marker the gaps that were bridged, from frame to past frame of the file.
    """

    def __init__(
        self, tracks: Tracks, groups: Groups, rate: float, where: str, report: ImportReport
    ) -> None:
        """Begin with what the file holds.

        Args:
            tracks: Trajectories by marker; changed in place.
            groups: Which markers show which point.
            rate: Frames per second, Hz.
            where: What an error calls the recording.
            report: Is told of every step.
        """
        self.tracks = tracks
        self.groups = groups
        self.first = 0
        self.lost_trunk: Array | None = None
        self.gaps: dict[str, list[tuple[int, int]]] = {}
        self._rate = rate
        self._where = where
        self._findings = report

    def clean(self, options: ReadingOptions) -> None:
        """Cut out the wanted time, flag or repair jumps, and bridge or cut away gaps.

        Raises:
            BadOptionError: The wanted time is outside the recording.
            MotionFileError: A marker is missing throughout, or for too long.
        """
        self._cut_time(options.start or 0.0, options.end)
        for name in self._arm_markers:
            if missing(self.tracks[name]).all():
                raise MotionFileError(
                    f"{self._where}: marker {name} is missing in all {self.frames} frames",
                    remedy=self._without(name) or "the arms cannot be followed without it",
                )
        for point in ARM_POINTS:
            if np.any([missing(self.tracks[name]) for name in self.groups[point]], axis=0).all():
                raise MotionFileError(
                    f"{self._where}: {' and '.join(self.groups[point])} are never seen together,"
                    f" and the {point.replace('_', ' ')} needs both"
                )
        self._jumps(repair=options.repair)
        self._long_gaps(options.max_gap, longest=options.longest)
        self._trim_ends(self._arm_markers, "arms")
        self._check_torso(options.max_gap)
        self._trim_ends([*self.tracks], "arms and the torso")
        self._bridge()

    def points(self) -> Tracks:
        """Return the points of the body; the markers are given up on the way."""
        uses = [name for group in self.groups.values() for name in group]
        points = {}
        for point, group in self.groups.items():
            points[point] = np.mean([self.tracks[name] for name in group], axis=0)
            for name in group:
                uses.remove(name)
                if name not in uses:
                    del self.tracks[name]
        return points

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(next(iter(self.tracks.values())))

    @property
    def _arm_markers(self) -> list[str]:
        return list(dict.fromkeys(name for point in ARM_POINTS for name in self.groups[point]))

    def _without(self, name: str) -> str:
        """Return how to do without a marker that has others beside it; "" if it has none."""
        for point in ARM_POINTS:
            others = [other for other in self.groups[point] if other != name]
            if name in self.groups[point] and others:
                mapping = placeholder("map", f'"{point}={"+".join(others)}"')
                return f"do without it with {mapping}"
        return ""

    def _cut(self, first: int, end: int) -> None:
        self.tracks = {name: track[first:end] for name, track in self.tracks.items()}
        self.first += first

    def _cut_time(self, start: float, end: float | None) -> None:
        duration = self.frames / self._rate
        if start >= duration:
            raise BadOptionError(
                option="start",
                value=start,
                expected=f"less, as {self._where} lasts {duration:.2f} s",
            )
        if end is not None and end > duration + 1.0 / self._rate:
            self._findings.warn(
                f"the recording ends at {duration:.2f} s", remedy=f"{{end={end:g}}} asks for more"
            )
        if start > 0 or end is not None:
            last = self.frames if end is None else min(self.frames, round(end * self._rate))
            first = round(start * self._rate)
            if last - first < 2:
                raise BadOptionError(
                    f"from {start:g} to {last / self._rate:.2f} s {self._where} has"
                    f" {max(0, last - first)} frame(s) at {self._rate:g} Hz; expected a longer time"
                )
            self._cut(first, last)
            self._findings.note(
                f"cut to {start:g}-{last / self._rate:.2f} s, {self.frames} frames, as requested"
            )

    def _jumps(self, *, repair: bool) -> None:
        means = {p: np.mean([self.tracks[n] for n in self.groups[p]], axis=0) for p in ARM_POINTS}
        arm = arm_length(means)
        found = {n: single_frame_jumps(self.tracks[n], arm) for n in self._arm_markers}
        found = {name: frames for name, frames in found.items() if len(frames)}
        if not found:
            return
        count = sum(len(frames) for frames in found.values())
        listed = "; ".join(
            f"{name} in frame {_listed(self.first + frames + 1)}" for name, frames in found.items()
        )
        if not repair:
            jumps = _count(count, "single-frame jump")
            self._findings.warn(f"{jumps} ({listed})", remedy="{repair} bridges them")
            return
        for name, frames in found.items():
            self.tracks[name][frames] = np.nan
        self._findings.note(f"{_count(count, 'single-frame jump')} bridged ({listed})")

    def _long_gaps(self, max_gap: float, *, longest: bool) -> None:
        gaps = [
            (first, end, name)
            for name in self._arm_markers
            for first, end in self._too_long(name, max_gap)
        ]
        if not gaps:
            return
        clean = np.ones(self.frames, bool)
        for first, end, _ in gaps:
            clean[first:end] = False
        whole = self._whole(self._arm_markers)
        first, end = max(
            (_trimmed(run, whole) for run in runs(clean)),
            key=lambda run: run[1] - run[0],
            default=(0, 0),
        )
        usable = (end - first) / self._rate >= _SHORTEST
        kept = (
            f"frames {self.first + first + 1} to {self.first + end},"
            f" {(end - first) / self._rate:.2f} s"
        )
        gap = self._described(gaps)
        if longest and usable:
            self._cut(first, end)
            self._findings.note(
                f"kept {kept}, the longest stretch without long gaps, as requested: {gap}"
            )
            return
        most = max(end - first for first, end, _ in gaps) / self._rate
        inside = bool(whole.any()) and all(
            first > 0 and end < self.frames for first, end, _ in gaps
        )
        bridged = np.ceil(100 * most - 1e-6) / 100
        ways = [f"bridge them with {{max_gap={bridged:g}}}"] * inside
        ways += [f"keep the longest clean stretch ({kept}) with {{longest}}"] * usable
        if most > _INVENTED:
            ways.reverse()
        raise MotionFileError(
            f"{self._where}: {gap}, longer than {max_gap:g} s",
            remedy=", or ".join(ways) or "too little is left; record it anew",
        )

    def _described(self, gaps: list[tuple[int, int, str]]) -> str:
        """Name the first of some gaps, and how many more there are."""
        first, end, name = min(gaps)
        more = len(gaps) - 1
        return (
            f"marker {name} is missing in frames {self.first + first + 1} to {self.first + end}"
            f" ({(end - first) / self._rate:.2f} s)"
            + (f" and there {_are(more, 'more such gap')}" if more else "")
        )

    def _too_long(self, name: str, max_gap: float) -> list[tuple[int, int]]:
        """Return the gaps of a marker that are longer than what may be bridged."""
        limit = max_gap * self._rate + 1e-6
        return [run for run in runs(missing(self.tracks[name])) if run[1] - run[0] > limit]

    def _whole(self, names: Iterable[str]) -> Mask:
        """Tell in which frames all of some markers are seen, shape (T,)."""
        whole = np.ones(self.frames, bool)
        for name in names:
            whole &= ~missing(self.tracks[name])
        return whole

    def _trim_ends(self, names: Sequence[str], what: str) -> None:
        """Cut off ends at which a marker is missing: there is nothing to interpolate between."""
        first, end = _trimmed((0, self.frames), self._whole(names))
        if end <= first:
            raise MotionFileError(
                f"{self._where}: at no time all markers of the {what} are seen; record it anew"
            )
        last = self.frames - end
        if first or last:
            self._findings.note(
                f"cut {_count(first, 'frame')} at the start and {last} at the end, where markers"
                f" of the {what} are missing"
            )
            self._cut(first, end)

    def _check_torso(self, max_gap: float) -> None:
        """Do without torso markers that are missing for too long."""
        names = [n for point in TORSO_POINTS for n in self.groups.get(point, ())]
        lost = {name for name in names if self._too_long(name, max_gap)}
        if not lost and self._whole(names).any():
            return
        longest = {
            n: max((e - f for f, e in runs(missing(self.tracks[n]))), default=0) for n in names
        }
        name = max(names, key=longest.__getitem__)
        missed = f"torso marker {name} is missing for up to {longest[name] / self._rate:.2f} s"
        others = self._torso_without(lost)
        if others is None:
            self._findings.warn(
                f"{missed}; the torso is taken as upright instead, so that a bend moves the arms"
            )
            pelvis, neck = (
                np.mean([self.tracks[n] for n in self.groups[p]], axis=0) for p in TORSO_POINTS
            )
            seen = ~missing(neck - pelvis)
            self.lost_trunk = (neck - pelvis)[seen] if seen.any() else None
        else:
            used = "; ".join(f"{point} {' + '.join(group)}" for point, group in others.items())
            self._findings.warn(f"{missed}; the torso is taken from others: {used}")
        arms = {point: self.groups[point] for point in ARM_POINTS}
        self.groups = arms | (others or {})
        kept = {name for group in self.groups.values() for name in group}
        self.tracks = {name: self.tracks[name] for name in self.tracks if name in kept}

    def _torso_without(self, lost: set[str]) -> Groups | None:
        """Return torso points without some markers, None if too few are left.

        Of four markers of the pelvis, two in front and two behind, either pair will do; for the
        neck the shoulders.
        """
        pelvis, neck = (self.groups[point] for point in TORSO_POINTS)
        shoulders = (*self.groups["left_shoulder"], *self.groups["right_shoulder"])
        pelvises = [pelvis, pelvis[2:], pelvis[:2]] if len(pelvis) == 4 else [pelvis]
        whole = [
            next((group for group in groups if not lost & set(group)), None)
            for groups in (pelvises, [neck, shoulders])
        ]
        groups = {p: g for p, g in zip(TORSO_POINTS, whole, strict=True) if g is not None}
        markers = [name for group in groups.values() for name in group]
        return groups if len(groups) == 2 and self._whole(markers).any() else None

    def _bridge(self) -> None:
        for name, track in self.tracks.items():
            gaps = runs(missing(track))
            if gaps:
                self.gaps[name] = [(self.first + first, self.first + end) for first, end in gaps]
                first, end = max(gaps, key=lambda gap: gap[1] - gap[0])
                if (end - first) / self._rate > _INVENTED:
                    self._findings.warn(
                        f"{name} is bridged over {(end - first) / self._rate:.2f} s from frame"
                        f" {self.first + first + 1} on: that movement is invented"
                    )
                self._findings.note(
                    f"{name}: {_count(sum(e - f for f, e in gaps), 'missing sample')} bridged in"
                    f" {_count(len(gaps), 'gap')}, the longest frames {self.first + first + 1} to"
                    f" {self.first + end} ({(end - first) / self._rate:.2f} s)"
                )
        fill_gaps(self.tracks.values())


def _listed(frames: NDArray[np.int_]) -> str:
    more = f" and {len(frames) - _MOST_LISTED} more" if len(frames) > _MOST_LISTED else ""
    return ", ".join(map(str, frames[:_MOST_LISTED])) + more


def _trimmed(run: tuple[int, int], whole: Mask) -> tuple[int, int]:
    """Return a stretch from its first to past its last whole frame; (0, 0) if it has none."""
    inside = np.flatnonzero(whole[slice(*run)])
    return (run[0] + int(inside[0]), run[0] + int(inside[-1]) + 1) if len(inside) else (0, 0)


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


def _are(number: int, thing: str) -> str:
    return f"{'is' if number == 1 else 'are'} {_count(number, thing)}"
