"""Figures as PNG files, and the labels in those over time."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.visualization.responsibility_strip import label_runs

__all__ = ["MOST_NAMED_RUNS", "draw_labels", "figure_file", "label_decades"]

Array = NDArray[np.float64]

MOST_NAMED_RUNS = 40
"""Number of stretches of labels beyond which their names would overlap."""

_DPI = 110
# A character that the font lacks is drawn as a box; the warning's text depends on the version.
_MISSING_GLYPH = r"Glyph \d+|Matplotlib currently does not support"


@contextlib.contextmanager
def figure_file(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Yield an empty figure, and save it on success.

    Text is drawn literally and never parsed as mathematics, because names of files and labels may
    contain "$". A logarithmic axis therefore needs `label_decades`, as matplotlib's labels are
    mathematics. All other parameters are those of the user's matplotlibrc; all are restored.

    Args:
        path: The PNG file.
        width: Width, inches.
        height: Height, inches.

    Yields:
        The figure, created without pyplot.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    # Texts read these when they are created; those of ticks are created when the figure is saved.
    literal = matplotlib.rc_context(
        {"text.parse_math": False, "text.usetex": False, "axes.formatter.use_mathtext": False}
    )
    with literal, warnings.catch_warnings():
        warnings.filterwarnings("ignore", _MISSING_GLYPH)
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        with atomic_write(path) as temporary:
            figure.savefig(temporary, dpi=_DPI)


def label_decades(axis: Axis) -> None:
    """Label 1, 2 and 5 of each decade of a logarithmic axis, as plain numbers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


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
    if len(runs) > MOST_NAMED_RUNS:
        return
    top = axes[0].get_xaxis_transform()
    for label, start, end in runs:
        middle = 0.5 * (start + end) / rate
        axes[0].text(middle, 1.02, labels[label], transform=top, ha="center", va="bottom")
