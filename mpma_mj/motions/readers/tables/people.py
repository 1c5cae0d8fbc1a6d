"""Rows of several people in one table, which must not be read as one person."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers.cells import is_missing
from mpma_mj.motions.readers.recording import Tracks
from mpma_mj.motions.readers.tables.times import Where
from mpma_mj.utils.text import listing

__all__ = ["refuse_alternating", "refuse_several"]

Array = NDArray[np.float64]

_MOST = 6  # people whose rows alternate
_FARTHER = 3.0  # times that it is to another person than to oneself a frame later (choice)
_APART = 0.03  # of a body's width that two people are at least apart: places may be rounded
_LOOKED_AT = 4096  # rows
_MOST_LISTED = 5


def refuse_several(path: Path, title: str, people: Sequence[str]) -> None:
    """Refuse a table whose column of people names several.

    Args:
        path: The file.
        title: Title of the column.
        people: Its cells, one for each row.

    Raises:
        MotionFileError: They are several, of whom one has more than one row.
    """
    named = [person for person in people if not is_missing(person)]
    several = list(dict.fromkeys(named))
    if len(several) < 2 or len(several) == len(named):  # then it counts rows
        return
    raise MotionFileError(
        f"{path}: has rows of {len(several)} people or takes, as column {title} has"
        f" {listing(several, _MOST_LISTED)}; keep the rows of one"
    )


def refuse_alternating(path: Path, tracks: Tracks, counter: Array | None, where: Where) -> None:
    """Refuse a table in which rows of several people alternate, or have the same time.

    Args:
        path: The file.
        tracks: Trajectories, each shape (T, 3), NaN where not seen.
        counter: Number or time of every row, shape (T,), if the table has one.
        where: Names a row.

    Raises:
        MotionFileError: From row to row every point is far away, or some point in a row of the
            same time, but near to where it is in another row close by.
    """
    some = [track[:_LOOKED_AT] for track in tracks.values() if track.any()]
    if not some:
        return
    places = np.stack(some, axis=1)  # (T, points, 3)
    least = _APART * _extent(places)
    usual = {k: _usual_way(places[k:], places[:-k]) for k in range(1, _MOST + 1)}
    # Of one person who shakes the arms, the shoulders stay: so every point has to alternate.
    ratios = {k: _ratios(usual[1], usual[k], least).min() for k in range(2, _MOST + 1)}
    people = max(ratios, key=lambda k: ratios[k])
    if ratios[people] > _FARTHER:
        raise MotionFileError(
            f"{path}: the rows of {people} people seem to alternate, as a row continues the motion"
            f" of the one {people} before; keep the rows of one"
        )
    if counter is None:
        return
    counter = counter[: len(places)]
    second = 2 + np.flatnonzero(counter[2:-1] == counter[1:-2])  # rows with the time of the last
    if not len(second):
        return
    apart = _usual_way(places[second], places[second - 1])
    near = [_ways(places[second - i], places[second + j]) for i in (0, 1) for j in (1, -2)]
    if _ratios(apart, _medians(np.fmin.reduce(near)), least).max() > _FARTHER:
        raise MotionFileError(
            f"{path}: {where(second[0] - 1)} and {where(second[0])} have the same time, but places"
            " far apart, as those of several people; keep the rows of one"
        )


def _ways(some: Array, others: Array) -> Array:
    """Return how far points are apart in rows of places, shape (T, points)."""
    return np.linalg.norm(some - others, axis=2)


def _usual_way(some: Array, others: Array) -> Array:
    """Return the median distance of every point, shape (points,)."""
    return _medians(_ways(some, others))


def _medians(ways: Array) -> Array:
    """Return the medians of columns without their gaps, shape (points,), 0 for gaps alone."""
    return np.array([np.median(c) if len(c := w[np.isfinite(w)]) else 0.0 for w in ways.T])


def _extent(places: Array) -> float:
    """Return how far apart the points of a row usually are, from places, (T, points, 3)."""
    wide = np.fmax.reduce(places, axis=1) - np.fmin.reduce(places, axis=1)
    return float(_medians(np.linalg.norm(wide, axis=1)[:, None])[0])


def _ratios(ways: Array, shorter: Array, least: float) -> Array:
    """Return how many times as long each point's ways are as others, 0 below the least way."""
    with np.errstate(over="ignore"):
        return np.where(ways < least, 0.0, ways / np.maximum(shorter, np.finfo(float).tiny))
