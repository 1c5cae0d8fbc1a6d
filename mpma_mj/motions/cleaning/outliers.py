"""Places far outside the body, such as 9999 for a marker that was not seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import segments
from mpma_mj.motions.cleaning.trajectories import Trajectories, missing
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.utils.text import listing

__all__ = ["far_from_body", "overstretched", "remove_outliers"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Distance from the middle of the markers, as a multiple of what is usual, from which a place is
# none of the body; a stretched arm reaches 2.5 times as far as hanging markers (choice).
_FAR = 5.0
_STRETCHED = 3.0  # times its usual length, which no estimate of a segment reaches (choice)
_MOST_LISTED = 5  # markers in a message
_ONE_PLACE = 0.02  # of the usual distance, under which most markers lie in one place (choice)
_FEWEST = 3  # markers of which a frame shows where the body is
_AT_ONCE = 1 << 12  # frames


def remove_outliers(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Make gaps of places far outside the body, and of those that stretch an arm far too long.

    Raises:
        MotionFileError: A marker of the arms has no other places.
    """
    tracks = trajectories.tracks
    found: dict[str, Mask] = {}
    for name, far in zip(tracks, far_from_body(list(tracks.values())), strict=True):
        _remove(trajectories, name, far, found)
    points = {point: trajectories.mean(point) for point in trajectories.arm_points}
    for point, far in overstretched(points).items():
        for name in trajectories.groups[point]:
            _remove(trajectories, name, far, found)
    if not found:
        return
    trajectories.outliers = set(found)
    listed = [
        f"{name} ({far.sum()} frame{'' if far.sum() == 1 else 's'} from"
        f" {trajectories.first + np.argmax(far) + 1} on)"
        for name, far in found.items()
    ]
    report.warn(
        f"places far outside the body are taken as missing: {listing(listed, _MOST_LISTED)}"
    )


def _remove(trajectories: Trajectories, name: str, far: Mask, found: dict[str, Mask]) -> None:
    """Make gaps in a marker's trajectory where it is far, and note where that is."""
    track = trajectories.tracks[name]
    far = far & ~missing(track)
    if not far.any():
        return
    trajectories.tracks[name] = np.where(far[:, None], np.nan, track)
    found[name] = found.get(name, np.zeros(len(far), bool)) | far
    if name in trajectories.arm_markers and missing(trajectories.tracks[name]).all():
        x, y, z = track[np.argmax(far)]
        raise MotionFileError(
            f"{trajectories.where}: marker {name} lies far outside the body in all frames in which"
            f" it is seen, such as at ({x:.6g}, {y:.6g}, {z:.6g})",
            remedy="correct it, or name another with {map}",
        )


def overstretched(points: dict[str, Array]) -> dict[str, Mask]:
    """Find the points because of which a segment is several times as long as usual.

    Of an arm's two segments that is the wrist for the forearm, the elbow for both, and for the
    upper arm alone the shoulder, if it is also far from the other one, else elbow and wrist.

    Args:
        points: The points of `body.ARM_POINTS`, or of one arm, each shape (T, 3).

    Returns:
        For each such point the frames, shape (T,).
    """
    shoulders = [points[f"{side}_shoulder"] for side in SIDES if f"{side}_shoulder" in points]
    apart = _is_long(shoulders[0] - shoulders[-1])
    long = {name: _is_long(vectors) for name, vectors in segments(points).items()}
    found = {}
    for side in SIDES:
        if f"{side} forearm" in long:
            upper, fore = long[f"{side} upper arm"], long[f"{side} forearm"]
            moved = upper & ~fore & ~apart
            found[f"{side}_shoulder"] = upper & ~fore & apart
            found[f"{side}_elbow"] = (upper & fore) | moved
            found[f"{side}_wrist"] = (fore & ~upper) | moved
    return {point: mask for point, mask in found.items() if mask.any()}


def _is_long(vectors: Array) -> Mask:
    """Return in which frames vectors, shape (T, 3), are several times as long as usual."""
    length = np.linalg.norm(vectors, axis=1)
    known = length[~np.isnan(length)]
    return length > _STRETCHED * np.median(known) if known.any() else np.zeros(len(length), bool)


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
