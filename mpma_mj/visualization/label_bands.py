"""Labels in figures over time: bands behind the curves, and names above them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mpma_mj.visualization.responsibility_strip import label_runs

__all__ = ["draw_labels"]

Array = NDArray[np.float64]

# With more stretches of labels than this the names would overlap.
_MOST_NAMED_RUNS = 40


def draw_labels(axes: Sequence[Axes], context: Array, labels: Sequence[str], rate: float) -> None:
    """Draw every other stretch of a label as a band, and the labels above the first axes.

    Args:
        axes: Axes over time in s, from top to bottom.
        context: Context, shape (T, C).
        labels: Label of each entry of the context, C of them.
        rate: Steps per second, Hz.
    """
    runs = label_runs(context)
    for axis in axes:
        for _, start, end in runs[1::2]:
            axis.axvspan(start / rate, end / rate, color="0.92", zorder=0)
        axis.margins(x=0)
        axis.spines[["top", "right"]].set_visible(False)
    if len(runs) > _MOST_NAMED_RUNS:
        return
    top = axes[0].get_xaxis_transform()
    for label, start, end in runs:
        middle = 0.5 * (start + end) / rate
        axes[0].text(middle, 1.02, labels[label], transform=top, ha="center", va="bottom")
