"""View of a person in a video: segments that are foreshortened, whose directions are lost."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.utils.text import listing

__all__ = ["bridge_end_on", "check_view"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SEGMENTS = (("upper arm", "shoulder", "elbow"), ("forearm", "elbow", "wrist"))
# Of what is usual at the longest: the cosine of the angle between a segment and the picture.
_SHORT = 0.65  # 50° (choice)
_END_ON = 0.15  # 81°, where no direction is left (choice)
_USUAL = 95.0  # percentile of its lengths at which a segment counts as parallel to the picture
# Least lengths of bodies, over the trunk's, where a segment is never parallel to the picture.
_LEAST = {"upper arm": 0.4, "forearm": 0.35, "shoulders": 0.5}
_SHORTEST = 0.1  # s that count (choice)
_MOST_LISTED = 5


def bridge_end_on(tracks: Tracks) -> None:
    """Turn segments that point to the camera, in place, evenly from the direction before to after.

    What is left of them in the picture has no direction, but passes through every one.

    Args:
        tracks: Places in the picture, shape (T, 3), z = 0, NaN where not seen.
    """
    for side, (_, first, last) in itertools.product(SIDES, _SEGMENTS):
        way = tracks[f"{side}_{last}"] - tracks[f"{side}_{first}"]
        shortest = _END_ON * _longest(way)
        end_on, clear = _length(way) < shortest, _length(way) >= shortest
        if not (end_on.any() and clear.any()):
            continue
        angles = np.unwrap(np.arctan2(way[clear, 1], way[clear, 0]))
        angles = np.interp(np.flatnonzero(end_on), np.flatnonzero(clear), angles)
        new = shortest * np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)
        for point in {last, "wrist"}:  # the forearm keeps its direction
            tracks[f"{side}_{point}"][end_on] += new - way[end_on]


def check_view(tracks: Tracks, start: float, rate: float, report: ImportReport) -> None:
    """Warn of times at which an arm points to the camera, or the torso is turned from it.

    A segment that is foreshortened, compared with its longest of the video, does either.

    Args:
        tracks: Places, x and y in the picture, shape (T, 3), NaN where not seen.
        start: Time of the first frame, s.
        rate: Frames per second, Hz.
        report: Gets the warnings.
    """
    trunk = np.inf
    if {"left_hip", "right_hip"} <= tracks.keys():
        shoulders, hips = (
            tracks[f"left_{part}"] + tracks[f"right_{part}"] for part in ("shoulder", "hip")
        )
        trunk = float(np.nanmedian(0.5 * _length(shoulders - hips)))
    for side in SIDES:
        short = np.zeros(len(next(iter(tracks.values()))), bool)
        for name, first, last in _SEGMENTS:
            if f"{side}_{last}" in tracks:
                short |= _is_short(
                    tracks[f"{side}_{last}"] - tracks[f"{side}_{first}"], name, trunk
                )
        if times := _times(short, start, rate):
            report.warn(
                f"the {side} arm points to the camera, or away from it, at {times}, where"
                " directions are off by 20 to 135°",
                remedy="dance with arms at the sides of the body",
            )
    across = tracks["left_shoulder"] - tracks["right_shoulder"]
    if times := _times(_is_short(across, "shoulders", trunk), start, rate):
        report.warn(
            f"the person is turned from the camera at {times}, where directions are wrong",
            remedy="dance facing the camera",
        )


def _is_short(way: Array, name: str, trunk: float) -> Mask:
    """Return where a segment, shape (T, 3), is foreshortened in the picture."""
    least = _LEAST[name] * trunk if np.isfinite(trunk) else 0.0
    return _length(way) < _SHORT * max(_longest(way), least)


def _length(way: Array) -> Array:
    return np.linalg.norm(way[:, :2], axis=1)


def _longest(way: Array) -> float:
    """Return the usual length of a segment when it is parallel to the picture."""
    length = _length(way)
    return float(np.nanpercentile(length, _USUAL)) if np.isfinite(length).any() else 0.0


def _times(mask: Mask, start: float, rate: float) -> str:
    """Return the stretches of frames in a mask that are long enough, in s; "" if none are."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    spans = [
        f"{start + first / rate:.1f}-{start + last / rate:.1f}"
        for first, last in edges.reshape(-1, 2)
        if last - first >= _SHORTEST * rate
    ]
    return f"{listing(spans, _MOST_LISTED)} s" if spans else ""
