"""Frames in which a marker was not seen."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["fill_gaps", "missing", "runs"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def missing(track: Array) -> Mask:
    """Tell in which frames a marker was not seen.

    Args:
        track: Trajectory, shape (T, 3), NaN where not seen.

    Returns:
        Shape (T,).
    """
    return np.any(np.isnan(track), axis=1)


def runs(mask: Mask) -> list[tuple[int, int]]:
    """Return the stretches in which a mask is true, each from its first frame to past its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]


def fill_gaps(tracks: Iterable[Array]) -> None:
    """Bridge gaps in place, by shape-preserving cubic interpolation (PCHIP).

    Args:
        tracks: Trajectories, each shape (T, 3), NaN where not seen, seen in the first and the
            last frame.
    """
    from scipy.interpolate import PchipInterpolator  # slow to import, needed by few runs

    for track in tracks:
        gone = missing(track)
        for first, end in runs(gone):
            # Its slopes depend on two samples at either side of the gap.
            near = np.flatnonzero(~gone[max(0, first - 3) : end + 3]) + max(0, first - 3)
            track[first:end] = PchipInterpolator(near, track[near])(np.arange(first, end))
