"""Points with the intervals of their means."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.evaluation.statistics import Interval
from mpma_mj.visualization.colours import PAPER

__all__ = ["draw_points"]


def draw_points(
    axis: Axes,
    places: NDArray[np.float64],
    found: Sequence[Interval],
    colour: str,
    *,
    label: str = "",
    filled: bool = True,
    horizontal: bool = False,
) -> None:
    """Draw the mean of each interval, and its ends where there are some.

    Args:
        axis: The axes.
        places: Where each is drawn, shape (N,).
        found: N intervals.
        colour: Colour of all.
        label: Name of all in a legend; none if not given.
        filled: Whether points are filled.
        horizontal: Whether values are on the horizontal axis.
    """
    means = np.array([one.mean for one in found])
    ends = np.array([[one.low, one.high] for one in found]).T
    length = np.nan_to_num(np.abs(ends - means))  # none where a single seed has no interval
    style: dict[str, Any] = {
        "fmt": "o",
        "color": colour,
        "markerfacecolor": colour if filled else PAPER,
        "label": label or None,
        "capsize": 2.5,
    }
    if horizontal:
        axis.errorbar(means, places, xerr=length, **style)
    else:
        axis.errorbar(places, means, yerr=length, **style)
