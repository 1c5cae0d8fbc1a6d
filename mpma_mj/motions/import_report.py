"""Report of an import: what a recording contains, what was done to it, what may be wrong."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import RecordingWarning, printable
from mpma_mj.motions.mapping import Groups
from mpma_mj.utils.text import listing

if TYPE_CHECKING:
    from mpma_mj.motions.motion import Motion  # whose file readers read

__all__ = ["ImportReport"]

_MOST_LABELS = 12  # that are listed


@dataclass(eq=False)
class ImportReport:
    """What happened on reading a motion; readers and stages of cleaning add to it.

    Attributes:
        steps: What was found or done, in order.
        doubts: What may be wrong, each with what was used instead.
        format: Kind of the file.
        groups: Which markers show which point of the body.
        names: All points of the file.
        frames: Number of frames of the file.
        rate: Frames per second of the file, Hz.
        lengths: Mean and standard deviation of each arm segment's length, in m, or in the
            file's unit where that is unknown.
        metric: Whether the lengths are in m.
        times: When each posture was taken, shape (T,), s from the recording's first frame.
        gaps: Gaps that were filled, by marker, each from and to in such seconds.
    """

    steps: list[str] = field(default_factory=list)
    doubts: list[RecordingWarning] = field(default_factory=list)
    format: str = ""
    groups: Groups = field(default_factory=dict)
    names: tuple[str, ...] = ()
    frames: int = 0
    rate: float = math.nan
    lengths: dict[str, tuple[float, float]] = field(default_factory=dict)
    metric: bool = True
    times: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    gaps: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    @property
    def warnings(self) -> list[str]:
        """What may be wrong, as text for users of Python."""
        return [str(doubt) for doubt in self.doubts]

    def note(self, step: str) -> None:
        """Add a step."""
        self.steps.append(printable(step))

    def warn(self, warning: str, *, remedy: str = "") -> None:
        """Add a warning.

        Args:
            warning: What may be wrong, and what was used instead.
            remedy: How to mend it; `{name}` and `{name=value}` stand for options.
        """
        self.doubts.append(RecordingWarning(warning, remedy=remedy))

    def settle(self, option: str) -> None:
        """Drop the warnings whose remedy is an option, as it is given."""
        self.doubts = [doubt for doubt in self.doubts if f"{{{option}}}" not in doubt.remedy]

    def emit_warnings(self, source: str | Path) -> None:
        """Issue the warnings as Python's, each with the file that it is about."""
        for doubt in self.doubts:
            warnings.warn(doubt.with_context(source), stacklevel=3)

    def lines(self, motion: Motion) -> list[str]:
        """Return lines about the recording, every step of its import, and the motion."""
        lines = [
            f"{motion.name}: {self.format}, {self.frames} frames at {self.rate:g} Hz"
            f" ({self.frames / self.rate:.2f} s)"
            + (f", {len(self.names)} points" if self.names else "")
        ]
        lines += [f"  {point:<15} {' + '.join(group)}" for point, group in self.groups.items()]
        lines += [f"  {step}" for step in self.steps]
        lines.append(
            f"motion: {len(motion)} postures at {motion.rate:g} Hz ({motion.duration:.2f} s),"
            f" labels {listing(motion.labels, _MOST_LABELS)}"
        )
        if self.lengths:
            unit = "m" if self.metric else "units of the file"
            lines.append(f"segments: mean length, {unit}, and how much it varies")
        for name, (mean, deviation) in self.lengths.items():
            lines.append(f"  {name:<15} {mean:.3f}  ±{100 * deviation / mean:.1f} %")
        return [printable(line) for line in lines]
