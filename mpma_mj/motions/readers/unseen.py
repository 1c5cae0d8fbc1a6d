"""Frames in which a point was not seen, however a file marks them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recording import Tracks

__all__ = ["mark_unseen"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FARTHEST = 1e9  # what is farther away, in any unit, is no place
# Numbers of nothing but nines, as 99.9 and 9999: what stands for a missing value in most files.
_NINES = np.array([10.0**e - 10.0**-d for e in range(2, 10) for d in range(5)])
_PLACEHOLDERS = np.unique(np.concatenate([_NINES, _NINES.astype(np.float32)]))
_AMID = 0.75  # of the body's extent that its nearest point is at most from the origin (choice)
_TOO_FAR = 20.0  # times as far as a body is wide (choice)
_FEWEST = 4  # points of which the middle is the body's though one is wrong
_SHARE = 0.1  # of a placeholder that it is at least away from all places (choice)


def mark_unseen(tracks: Tracks, report: ImportReport) -> None:
    """Set to NaN, in place, where points were not seen.

    A point was not seen where a coordinate is not finite or a placeholder, where it is far from
    all other points, and where it is exactly 0, 0, 0: unless it is so throughout and amid the
    others, when it is the origin, as the pelvis is in coordinates relative to it.

    Args:
        tracks: Trajectories by name, each shape (T, 3).
        report: Gets a warning of placeholders, and a note of the origin.
    """
    zero = {name: (track == 0.0).all(axis=1) for name, track in tracks.items()}
    held = {name: _placeholders(track) for name, track in tracks.items()}
    _add_outliers(tracks, held)
    _report_placeholders(held, report)
    for name, track in tracks.items():
        track[~np.isnan(held[name]) | ~np.isfinite(track).all(axis=1)] = np.nan
        if not (len(track) and zero[name].all()):
            track[zero[name]] = np.nan
    for name in [name for name, mask in zero.items() if len(mask) and mask.all()]:
        others = [track for other, track in tracks.items() if not zero[other].all()]
        if _is_amid(others):
            report.note(f"{name} is 0, 0, 0 throughout: the origin")
        else:
            tracks[name][:] = np.nan


def _placeholders(track: Array) -> Array:
    """Return the placeholder in each place of a trajectory, shape (T, 3), NaN without, (T,).

    They are numbers of nines, or one number in all three axes, and lie outside the range of all
    other places by more than that range; or there are no other places.
    """
    size = np.abs(track)
    same = (track[:, 0] == track[:, 1]) & (track[:, 1] == track[:, 2]) & (track[:, 0] != 0.0)
    found = np.full(len(track), np.nan)
    for column, absolute in zip(track.T, size.T, strict=True):
        nines = _is_placeholder(absolute)
        odd = same | nines
        usual = column[~odd & (absolute < _FARTHEST)]
        if len(usual):
            low, high = usual.min(), usual.max()
            outside = np.abs(column - np.clip(column, low, high))
            odd &= outside > np.maximum(high - low, _SHARE * absolute)
        else:
            odd = nines
        odd |= absolute > _FARTHEST
        found[odd] = column[odd]
    return found


def _add_outliers(tracks: Tracks, held: dict[str, Array]) -> None:
    """Add, in place, to placeholders what is much farther from the other points than a body is."""
    if len(tracks) < _FEWEST:
        return
    places = np.stack([*tracks.values()])  # (points, T, 3)
    places[(places == 0.0).all(axis=2) | ~np.isnan([*held.values()])] = np.nan
    extent = np.linalg.norm(np.fmax.reduce(places) - np.fmin.reduce(places), axis=1)
    usual = float(np.median(extent[np.isfinite(extent)])) if np.isfinite(extent).any() else 0.0
    wide = np.flatnonzero(extent > _TOO_FAR * usual)
    if not len(wide) or usual == 0.0:
        return
    ways = places[:, wide] - np.nanmedian(places[:, wide], axis=0)  # of few frames: it is slow
    far = np.linalg.norm(ways, axis=2) > 0.5 * _TOO_FAR * usual
    for name, own, its_ways in zip(tracks, far, ways, strict=True):
        frames = wide[own]
        held[name][frames] = tracks[name][frames, np.abs(its_ways[own]).argmax(axis=1)]


def _is_placeholder(absolute: Array) -> Mask:
    """Return which of some absolute values, shape (T,), are numbers of nines."""
    at = np.searchsorted(_PLACEHOLDERS, absolute).clip(max=len(_PLACEHOLDERS) - 1)
    return np.equal(_PLACEHOLDERS[at], absolute)


def _is_amid(others: list[Array]) -> bool:
    """Return whether the origin is usually closer to one of some points than these are apart."""
    if not others:
        return False
    places = np.stack(others)  # (points, T, 3)
    places = places[:, np.isfinite(places).all(axis=(0, 2))]
    nearest = np.linalg.norm(places, axis=2).min(axis=0)
    apart = np.linalg.norm(places.max(axis=0) - places.min(axis=0), axis=1)
    return bool(len(nearest)) and bool(np.median(nearest) < _AMID * np.median(apart))


def _report_placeholders(held: dict[str, Array], report: ImportReport) -> None:
    found = {n: np.flatnonzero(~np.isnan(values)) for n, values in held.items()}
    found = {name: rows for name, rows in found.items() if len(rows)}
    if not found:
        return
    name, rows = next(iter(found.items()))
    more = f" and of {len(found) - 1} more points" if len(found) > 1 else ""
    count = sum(map(len, found.values()))
    samples = "1 sample" if count == 1 else f"{count} samples"
    report.warn(
        f"{held[name][rows[0]]:.6g} is no place: {samples} of {name}{more}, the first in row"
        f" {rows[0] + 1}, treated as missing"
    )
