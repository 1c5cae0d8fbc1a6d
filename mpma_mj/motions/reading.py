"""What comes of reading: a movement, and how it was come by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups
from mpma_mj.motions.motion import Motion

__all__ = ["Reading"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reading:
    """A movement, and what became of its recording on the way.

    Attributes:
        motion: The movement.
        report: What was found and done.
        format: Kind of the file.
        groups: Which markers show which point of the body.
        names: All points that the file has.
        frames: Number of frames in the file.
        rate: Frames per second of the file, Hz.
        lengths: Mean and standard deviation of each arm segment's length, in m, or in the
            file's unit where that is unknown.
        metric: Whether the lengths are in m.
        times: When each posture was taken, shape (T,), s from the recording's first frame.
        gaps: Stretches that were bridged, by marker, each from and to in such seconds.
    """

    motion: Motion
    report: ImportReport
    format: str
    groups: Groups
    names: tuple[str, ...]
    frames: int
    rate: float
    lengths: dict[str, tuple[float, float]]
    metric: bool
    times: Array
    gaps: dict[str, list[tuple[float, float]]]
