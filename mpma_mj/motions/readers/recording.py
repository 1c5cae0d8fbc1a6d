"""What every file format comes down to: named points and how often they were seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import Span

__all__ = ["RATES", "UNITS", "UPS", "Recording", "Tracks", "Unit", "Up"]

Tracks = dict[str, NDArray[np.float64]]
Unit = Literal["m", "cm", "mm", "inch"]
Up = Literal["x", "y", "z", "-x", "-y", "-z"]

UNITS: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
"""Length of each unit, m."""
RATES = (1.0, 10_000.0)
"""Rates at which movement is recorded, Hz."""
UPS: tuple[Up, ...] = get_args(Up)


@dataclass(frozen=True)
class Recording:
    """A file whose header has been read, and whose trajectories wait to be.

    Attributes:
        path: The file.
        format: What kind of file it is.
        names: The points that it has, in its order.
        load: Returns the trajectories of some points, each shape (T, 3), NaN where not seen.
        rate: Frames per second, Hz, if the file tells.
        unit: Length of the file's unit, m, if it tells.
        up: Axis that points up, if the file or its format tells.
        frames: Number of frames that the file says it has.
        spans: Labelled stretches of time that the file has.
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
