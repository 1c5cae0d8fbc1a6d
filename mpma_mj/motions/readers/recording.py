"""Recording: named points, their trajectories and what a file declares about them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import Span
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport

__all__ = ["RATES", "UNITS", "UPS", "Recording", "Tracks", "Unit", "Up", "unknown_rate"]

Tracks = dict[str, NDArray[np.float64]]
Unit = Literal["m", "cm", "mm", "inch", "ft"]
Up = Literal["x", "y", "z", "-x", "-y", "-z"]

UNITS: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "ft": 0.3048}
"""Length of each unit, m."""
RATES = (1.0, 10_000.0)
"""Lowest and highest rate of recordings, Hz."""
UPS: tuple[Up, ...] = get_args(Up)


@dataclass(frozen=True)
class Recording:
    """A file of which the header has been read, and not yet the trajectories.

    Attributes:
        path: The file.
        format: Name of its format.
        names: Its points, in order.
        load: Returns the trajectories of some points, each shape (T, 3), NaN where not seen.
        rate: Declared frames per second, Hz.
        unit: Declared length of the unit, m.
        up: Axis that points up, declared or that of the format.
        frames: Declared number of frames.
        spans: Labelled stretches of time.
        root: Joint from which a skeleton's legs branch, whatever its name.
        from_pictures: Whether points were found in pictures: their depth is rough, or left out.
    """

    path: Path
    format: str
    names: tuple[str, ...]
    load: Callable[[Sequence[str]], Tracks]
    rate: float | None = None
    unit: float | None = None
    up: Up | None = None
    frames: int | None = None
    spans: tuple[Span, ...] = ()
    root: str | None = None
    from_pictures: bool = False


def unknown_rate(path: Path, report: ImportReport) -> MotionFileError:
    """Return an error for a file without a rate, with the warning about its times."""
    problems = [doubt.args[0] for doubt in report.doubts]
    reason = next((f" ({problem})" for problem in problems if "times" in problem), "")
    return MotionFileError(
        f"{path}: does not declare its frame rate{reason}",
        remedy="give it with {rate_in}, such as {rate_in=50}",
    )
