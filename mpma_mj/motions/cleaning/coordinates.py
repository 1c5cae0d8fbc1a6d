"""Exchanged or constant coordinates: columns of a table that were moved."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["check_coordinates", "exchanged_coordinates"]

Array = NDArray[np.float64]

# Distances that bones keep; of the torso at least while shoulders are not shrugged.
_LINES = (
    *(
        (f"{s}_{a}", f"{s}_{b}")
        for s in SIDES
        for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
    ),
    *((f"{s}_shoulder", end) for s in SIDES for end in ("neck", "pelvis")),
    ("pelvis", "neck"),
    ("left_shoulder", "right_shoulder"),
)
_STEADIER = 3.0  # times (choice); 1.8 in the public recordings that the results list
_LESS_STEADY = 0.8  # times, of any distance
_EXACT = 1e-3  # of the longest distance's mean, to which none varies (choice)
_FEWEST, _ENOUGH = 20, 512  # frames


def check_coordinates(
    trajectories: Trajectories, options: ReadingOptions, report: ImportReport
) -> None:
    """Warn of two coordinates that are exchanged, and of the only one that never changes."""
    names = [*trajectories.tracks]
    seen = trajectories.seen(names)
    places = np.stack([track[seen] for track in trajectories.tracks.values()])
    places = places[:, :: places.shape[1] // _ENOUGH + 1]
    if places.shape[1] < _FEWEST:
        return
    groups = trajectories.groups
    weights = np.array(
        [
            [
                (name in groups[b]) / len(groups[b]) - (name in groups[a]) / len(groups[a])
                for name in names
            ]
            for a, b in _LINES
            if a in groups and b in groups
        ]
    )
    titles = [f"{axis} of {name}" for name in names for axis in "xyz"]
    pair = exchanged_coordinates(places, weights)
    if pair is not None:
        first, second = (titles[column] for column in pair)
        report.warn(
            f"{first} and {second} seem to be exchanged: with each in the other's place, distances"
            " that bones keep are far steadier; exchange those columns"
        )
    still = np.flatnonzero(np.ptp(places, axis=1).reshape(-1) == 0.0)
    if len(still) == 1:
        value = places.swapaxes(1, 2).reshape(len(titles), -1)[still[0], 0]
        report.warn(
            f"{titles[still[0]]} is {value:g} in all frames, while all other coordinates change;"
            " check which column it is in"
        )


def exchanged_coordinates(places: Array, weights: Array) -> tuple[int, int] | None:
    """Return the two coordinates of which the exchange makes distances much steadier.

    One distance then deviates far less from its mean, and none much more.

    Args:
        places: Trajectories of markers, shape (M, T, 3), without gaps, in any unit.
        weights: Weights of the markers in the vectors whose lengths bones keep, shape (L, M).

    Returns:
        Their numbers, from 0 to 3 M - 1; None if the places are best as they are.
    """
    vectors = np.einsum("lm,mta->lta", weights, places)
    exact = _EXACT * np.linalg.norm(vectors, axis=2).mean(axis=1).max()
    was = np.maximum(np.linalg.norm(vectors, axis=2).std(axis=1), exact)
    best, found = _STEADIER, None
    if was.max() < _STEADIER * exact:
        return None
    for one, other in itertools.combinations(range(3 * len(places)), 2):
        (m, a), (n, b) = divmod(one, 3), divmod(other, 3)
        changes = weights[:, [m, n]].any(axis=1)
        if was[changes].max(initial=0.0) < best * exact:
            continue
        way = places[n, :, b] - places[m, :, a]
        moved = vectors[changes]
        moved[:, :, a] += weights[changes, m, None] * way
        moved[:, :, b] -= weights[changes, n, None] * way
        now = np.maximum(np.linalg.norm(moved, axis=2).std(axis=1), exact)
        steadier = was[changes] / now
        if steadier.max() > best and steadier.min() > _LESS_STEADY:
            best, found = float(steadier.max()), (one, other)
    return found
