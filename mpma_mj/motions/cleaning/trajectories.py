"""Trajectories of a recording while they are cleaned."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.recording import Recording, Tracks

__all__ = ["Trajectories", "cut_time", "missing"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass
class Trajectories:
    """Trajectories that stages of cleaning change, and their place in the recording.

    Attributes:
        tracks: Trajectories by marker, later by point of the body, each shape (T, 3), NaN where
            not seen.
        groups: Which markers show which point of the body.
        rate: Frames per second of the recording, Hz.
        new_rate: Requested postures per second, Hz.
        recording: The file.
        first: Index of the first frame in the file.
        removed_trunk: Vectors from pelvis to neck, shape (N, 3), of frames in which both are seen,
            if they are seen too rarely to be a point.
        outliers: Markers of which places far outside the body became gaps.
        others: Names of the recording that are not recognised, where it shows no trunk.
    """

    tracks: Tracks
    groups: Groups
    rate: float
    new_rate: float
    recording: Recording
    first: int = 0
    removed_trunk: Array | None = None
    outliers: set[str] = field(default_factory=set)
    others: str = ""

    @property
    def where(self) -> str:
        """Name of the recording in messages."""
        return str(self.recording.path)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(next(iter(self.tracks.values())))

    @property
    def arm_points(self) -> list[str]:
        """Points of the arms that are recorded: of both, or of one."""
        return [point for point in ARM_POINTS if point in self.groups]

    @property
    def arm_markers(self) -> list[str]:
        """Markers of the arms."""
        return list(dict.fromkeys(name for p in self.arm_points for name in self.groups[p]))

    def cut(self, first: int, end: int) -> None:
        """Keep the frames from `first` to before `end`."""
        self.tracks = {name: track[first:end] for name, track in self.tracks.items()}
        self.first += first

    def mean(self, point: str) -> Array:
        """Return the mean of a point's markers, shape (T, 3)."""
        return np.mean([self.tracks[name] for name in self.groups[point]], axis=0)

    def seen(self, names: Iterable[str]) -> Mask:
        """Return in which frames all of some markers are seen, shape (T,)."""
        seen = np.ones(self.frames, bool)
        for name in names:
            seen &= ~missing(self.tracks[name])
        return seen


def missing(track: Array) -> Mask:
    """Return in which frames a marker was not seen, shape (T,), from its trajectory, (T, 3)."""
    return np.any(np.isnan(track), axis=1)


def cut_time(trajectories: Trajectories, options: ReadingOptions, report: ImportReport) -> None:
    """Keep the time from `start` to `end`.

    Raises:
        BadOptionError: That time is outside the recording, or too short.
    """
    start, end = options.start or 0.0, options.end
    where, rate = trajectories.where, trajectories.rate
    duration = trajectories.frames / rate
    if start >= duration:
        raise BadOptionError(
            option="start", value=start, expected=f"less, as {where} lasts {duration:.2f} s"
        )
    if end is not None and end > duration + 1.0 / rate:
        report.warn(
            f"the recording ends at {duration:.2f} s", remedy=f"{{end={end:g}}} is later than that"
        )
    if start == 0 and end is None:
        return
    last = trajectories.frames if end is None else min(trajectories.frames, round(end * rate))
    first = round(start * rate)
    if last - first < 2:
        raise BadOptionError(
            f"from {start:g} to {last / rate:.2f} s {where} has {max(0, last - first)} frame(s) at"
            f" {rate:g} Hz; give a longer time"
        )
    trajectories.cut(first, last)
    report.note(f"cut to {start:g}-{last / rate:.2f} s, {last - first} frames, as requested")
