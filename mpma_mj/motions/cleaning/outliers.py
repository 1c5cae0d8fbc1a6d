"""Places far outside the body, such as 9999 for a marker that was not seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["far_from_body", "remove_outliers"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Distance from the middle of the markers, as a multiple of what is usual, from which a place is
# none of the body; a stretched arm reaches 2.5 times as far as hanging markers (choice).
_FAR = 5.0
_ONE_PLACE = 0.02  # of the usual distance, under which most markers lie in one place (choice)
_FEWEST = 3  # markers of which a frame shows where the body is
_AT_ONCE = 1 << 12  # frames


def remove_outliers(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Make gaps of places far outside the body."""
    tracks = trajectories.tracks
    for name, far in zip(tracks, far_from_body(list(tracks.values())), strict=True):
        frames = np.flatnonzero(far)
        if not len(frames):
            continue
        x, y, z = tracks[name][frames[0]]
        report.warn(
            f"{name} lies far outside the body in {len(frames)} frame{'s' * (len(frames) != 1)},"
            f" the first {trajectories.first + frames[0] + 1} (at {x:.6g}, {y:.6g}, {z:.6g}): taken"
            " as missing there"
        )
        tracks[name] = np.where(far[:, None], np.nan, tracks[name])


def far_from_body(tracks: list[Array]) -> list[Mask]:
    """Find where each marker is far from the middle of all, or all are in one place.

    Args:
        tracks: Trajectories, each shape (T, 3), NaN where not seen.

    Returns:
        For each, whether its place is none of the body, shape (T,).
    """
    frames = len(tracks[0])
    some = _from_middle(np.stack([track[:: frames // _AT_ONCE + 1] for track in tracks]))
    medians = [np.median(row[~np.isnan(row)]) for row in some if not np.isnan(row).all()]
    usual = float(np.median(medians)) if medians else 0.0
    blocks = [
        _far(np.stack([track[i : i + _AT_ONCE] for track in tracks]), usual)
        for i in range(0, frames, _AT_ONCE)
    ]
    return list(np.concatenate(blocks, axis=1))


def _far(places: Array, usual: float) -> Mask:
    """Return which places, shape (M, T, 3), are none of a body of usual size, shape (M, T)."""
    away = _from_middle(places)
    seen = ~np.isnan(away)
    far = seen & (away > _FAR * usual)
    # Where most are lost at once, it is they that are in the middle of all.
    count = seen.sum(axis=0)
    close = (seen & (away <= _ONE_PLACE * usual)).sum(axis=0)
    together = (count >= _FEWEST) & (far.any(axis=0) | (close == count)) & (2 * close >= count)
    return far | (seen & together)


def _from_middle(places: Array) -> Array:
    """Return each marker's distance, (M, T), from the median of all, from places, (M, T, 3)."""
    ordered = np.sort(places, axis=0)  # NaN last
    count = np.sum(~np.isnan(places), axis=0)
    middle = np.take_along_axis(ordered, (np.maximum(count, 1) - 1)[None] // 2, axis=0)
    with np.errstate(over="ignore"):
        return np.linalg.norm(places - middle, axis=2)
