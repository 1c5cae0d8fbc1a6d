"""Whether left and right are what a file calls them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups, mapping_option

__all__ = ["check_sides"]

Array = NDArray[np.float64]

_MOSTLY = 0.5  # share of the time
_CLEARLY = 0.2  # of a forearm's length that it has to point forward or backward to count
_MOSTLY_BACKWARD = 0.75  # share of the time
_OFTEN = 0.1  # share of the time in which forearms have to point anywhere


def check_sides(
    points: dict[str, Array], posture: Array, groups: Groups, report: ImportReport
) -> None:
    """Warn of a file in which left and right seem to be swapped.

    Args:
        points: The points of `body.ARM_POINTS`, each shape (T, 3).
        posture: Postures, shape (T', 12).
        groups: Which markers show which point, for what mends it.
        report: Is told.
    """
    across = points["left_shoulder"] - points["right_shoulder"]
    middle = 0.5 * (points["left_shoulder"] + points["right_shoulder"])
    crossed = {
        side: np.sum((points[f"{side}_elbow"] - middle) * across, axis=1) * sign < 0
        for side, sign in (("left", 1.0), ("right", -1.0))
    }
    share = float(np.mean(crossed["left"] & crossed["right"]))
    if share > _MOSTLY:
        report.warn(
            f"both elbows are beyond the body's midline in {100 * share:.0f} % of the frames: left"
            " and right look swapped",
            remedy=f"{_swapped(groups, ('elbow', 'wrist'))} mends that",
        )
        return
    segments = posture.reshape(-1, 4, 3)
    # An elbow bends its forearm forwards; with left and right swapped, front is taken for back.
    bent = segments[:, 1::2, 0] - segments[:, 0::2, 0]
    # Only below the shoulder: over the head a bent elbow may point either way.
    clear = (np.abs(bent) > _CLEARLY) & (segments[:, 0::2, 2] < 0.0)
    backward = float(np.mean(bent[clear] < 0)) if clear.any() else 0.0
    if backward > _MOSTLY_BACKWARD and clear.mean() > _OFTEN:
        report.warn(
            f"forearms point backwards in {100 * backward:.0f} % of the frames in which they are"
            " bent: left and right look swapped, or up and down, or the file's axes are"
            " left-handed, as in Unity",
            remedy=f"{_swapped(groups, ('shoulder', 'elbow', 'wrist'))} mends the first, {{up}} the"
            " second",
        )


def _swapped(groups: Groups, parts: Sequence[str]) -> str:
    """Return the option with which some points change sides."""
    other = {f"{a}_{p}": groups[f"{b}_{p}"] for p in parts for a, b in (SIDES, SIDES[::-1])}
    return mapping_option(groups | other)
