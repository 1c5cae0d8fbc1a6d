"""Frames in which a point was not seen, however a file marks them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks

__all__ = ["mark_missing"]

Array = NDArray[np.float64]

_AMID = 0.75  # of the body's extent that its nearest point is at most from the origin (choice)


def mark_missing(tracks: Tracks, report: ImportReport) -> None:
    """Set to NaN, in place, where points were not seen.

    A point was not seen where a coordinate is not finite, and where it is exactly 0, 0, 0: unless
    it is so throughout and amid the others, when it is the origin, as the pelvis is in coordinates
    relative to it. Other numbers for a missing value are far outside the body; `cleaning.outliers`
    finds them.

    Args:
        tracks: Trajectories by name, each shape (T, 3).
        report: Gets a note of the origin.
    """
    zero = {name: (track == 0.0).all(axis=1) for name, track in tracks.items()}
    for name, track in tracks.items():
        track[~np.isfinite(track).all(axis=1)] = np.nan
        if not (len(track) and zero[name].all()):
            track[zero[name]] = np.nan
    for name in [name for name, mask in zero.items() if len(mask) and mask.all()]:
        others = [track for other, track in tracks.items() if not zero[other].all()]
        if _is_amid(others):
            report.note(f"{name} is 0, 0, 0 throughout: the origin")
        else:
            tracks[name][:] = np.nan


def _is_amid(others: list[Array]) -> bool:
    """Return whether the origin is usually closer to one of some points than these are apart."""
    if not others:
        return False
    places = np.stack(others)  # (points, T, 3)
    places = places[:, np.isfinite(places).all(axis=(0, 2))]
    nearest = np.linalg.norm(places, axis=2).min(axis=0)
    apart = np.linalg.norm(places.max(axis=0) - places.min(axis=0), axis=1)
    return bool(len(nearest)) and bool(np.median(nearest) < _AMID * np.median(apart))
