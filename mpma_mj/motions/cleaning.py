"""From raw trajectories to whole ones: what is missing is bridged, cut away, or refused."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.body import ARM_POINTS, TORSO_POINTS
from mpma_mj.motions.findings import Findings
from mpma_mj.motions.gaps import fill_gaps, longest_run, missing, runs
from mpma_mj.motions.jumps import single_frame_jumps
from mpma_mj.motions.markers import Groups
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length
from mpma_mj.motions.recording import Tracks

__all__ = ["Cleaner"]

Mask = NDArray[np.bool_]

_MOST_LISTED = 5


class Cleaner:
    """Trajectories on their way to being whole.

    Attributes:
        tracks: Trajectories by marker, each shape (T, 3), NaN where not seen.
        groups: Which markers show which point of the body.
        first: Index of their first frame in the file.
        gaps: For each marker the gaps that were bridged, from frame to past frame of the file.
    """

    def __init__(
        self, tracks: Tracks, groups: Groups, rate: float, where: str, findings: Findings
    ) -> None:
        """Begin with what the file holds.

        Args:
            tracks: Trajectories by marker; changed in place.
            groups: Which markers show which point.
            rate: Frames per second, Hz.
            where: What an error calls the recording.
            findings: Is told of every step.
        """
        self.tracks = tracks
        self.groups = groups
        self.first = 0
        self.gaps: dict[str, list[tuple[int, int]]] = {}
        self._rate = rate
        self._where = where
        self._findings = findings

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
                    f"{self._where}: marker {name} is missing in all {self._frames} frames; the"
                    " arms cannot be followed without it"
                )
        self._jumps(repair=options.repair)
        self._long_gaps(options.max_gap, longest=options.longest)
        self._trim_ends()
        self._check_torso(options.max_gap)
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
    def _frames(self) -> int:
        return len(next(iter(self.tracks.values())))

    @property
    def _arm_markers(self) -> list[str]:
        return list(dict.fromkeys(name for point in ARM_POINTS for name in self.groups[point]))

    def _cut(self, first: int, end: int) -> None:
        self.tracks = {name: track[first:end] for name, track in self.tracks.items()}
        self.first += first

    def _cut_time(self, start: float, end: float | None) -> None:
        duration = self._frames / self._rate
        if start >= duration:
            raise BadOptionError(
                f"from is {start:g}, but {self._where} lasts {duration:.2f} s; expected less"
            )
        if end is not None and end > duration + 1.0 / self._rate:
            self._findings.warn(f"--to is {end:g} s, but the recording ends at {duration:.2f} s")
        if start > 0 or end is not None:
            last = self._frames if end is None else min(self._frames, round(end * self._rate))
            self._cut(round(start * self._rate), last)
            self._findings.note(
                f"cut to {start:g}-{last / self._rate:.2f} s, {self._frames} frames, as asked"
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
            self._findings.warn(f"{count} single-frame jumps ({listed}); --repair bridges them")
            return
        for name, frames in found.items():
            self.tracks[name][frames] = np.nan
        self._findings.note(f"{count} single-frame jumps bridged ({listed})")

    def _long_gaps(self, max_gap: float, *, longest: bool) -> None:
        limit = max_gap * self._rate + 1e-9
        gaps = [
            (first, end, name)
            for name in self._arm_markers
            for first, end in runs(missing(self.tracks[name]))
            if end - first > limit
        ]
        if not gaps:
            return
        clean = np.ones(self._frames, bool)
        for first, end, _ in gaps:
            clean[first:end] = False
        kept_first, kept_end = longest_run(clean)
        kept = (
            f"frames {self.first + kept_first + 1} to {self.first + kept_end},"
            f" {(kept_end - kept_first) / self._rate:.2f} s"
        )
        first, end, name = min(gaps)
        gap = (
            f"marker {name} is missing in frames {self.first + first + 1} to {self.first + end}"
            f" ({(end - first) / self._rate:.2f} s)"
        )
        if not longest or kept_end - kept_first < 2:
            needed = np.ceil(100 * max(end - first for first, end, _ in gaps) / self._rate) / 100
            inside = all(first > 0 and end < self._frames for first, end, _ in gaps)
            raise MotionFileError(
                f"{self._where}: {gap}"
                + (f" and there are {len(gaps) - 1} more such gaps" if len(gaps) > 1 else "")
                + f", longer than {max_gap:g} s:"
                + (f" bridge them with --max-gap {needed:g}, or" if inside else "")
                + f" keep the longest clean stretch ({kept}) with --longest"
            )
        self._cut(kept_first, kept_end)
        self._findings.note(f"kept {kept}, the longest stretch without long gaps, as asked: {gap}")

    def _trim_ends(self) -> None:
        """Cut off ends at which a marker is missing: there is nothing to interpolate between."""
        seen = [np.flatnonzero(~missing(self.tracks[name])) for name in self._arm_markers]
        first, end = max(s[0] for s in seen), min(s[-1] for s in seen) + 1
        if end <= first:
            raise MotionFileError(f"{self._where}: in no frame all markers of the arms are seen")
        cut = int(first), int(self._frames - end)
        if any(cut):
            self._findings.note(
                f"cut {cut[0]} frames at the start and {cut[1]} at the end, where markers of the"
                " arms are missing"
            )
            self._cut(int(first), int(end))

    def _check_torso(self, max_gap: float) -> None:
        """Do without torso markers that are missing for too long."""
        names = [n for point in TORSO_POINTS for n in self.groups.get(point, ())]
        for name in names:
            gone = missing(self.tracks[name])
            lengths = [end - first for first, end in runs(gone)]
            if gone[0] or gone[-1] or max(lengths, default=0) > max_gap * self._rate + 1e-9:
                self._findings.warn(
                    f"torso marker {name} is missing for up to {max(lengths) / self._rate:.2f} s;"
                    " the torso is taken as upright instead, so that a bend moves the arms"
                )
                self.groups = {p: g for p, g in self.groups.items() if p not in TORSO_POINTS}
                kept = {name for group in self.groups.values() for name in group}
                self.tracks = {name: self.tracks[name] for name in self.tracks if name in kept}
                return

    def _bridge(self) -> None:
        for name, track in self.tracks.items():
            gaps = runs(missing(track))
            if gaps:
                self.gaps[name] = [(self.first + first, self.first + end) for first, end in gaps]
                first, end = max(gaps, key=lambda gap: gap[1] - gap[0])
                self._findings.note(
                    f"{name}: {sum(e - f for f, e in gaps)} missing samples bridged in"
                    f" {len(gaps)} gaps, the longest frames {self.first + first + 1} to"
                    f" {self.first + end} ({(end - first) / self._rate:.2f} s)"
                )
        fill_gaps(self.tracks.values())


def _listed(frames: NDArray[np.int_]) -> str:
    more = f" and {len(frames) - _MOST_LISTED} more" if len(frames) > _MOST_LISTED else ""
    return ", ".join(map(str, frames[:_MOST_LISTED])) + more
