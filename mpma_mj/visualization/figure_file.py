"""Figures as PNG files, and the labels in those over time.

matplotlib is imported when something is drawn, so that what can draw loads without it.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.visualization.responsibility_strip import label_runs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

__all__ = ["MOST_NAMED_RUNS", "draw_labels", "figure_file", "fitting", "label_decades"]

Array = NDArray[np.float64]

MOST_NAMED_RUNS = 40
"""Number of stretches of labels beyond which their names would overlap."""

_DPI = 110
_SHARE_OF_AXES = 0.85  # of a figure's width, at least
# A character that the font lacks is drawn as a box; the warning's text depends on the version.
_MISSING_GLYPH = r"Glyph \d+|Matplotlib currently does not support"


@contextlib.contextmanager
def figure_file(
    path: Path, width: float, height: float, layout: Literal["constrained"] | None = "constrained"
) -> Iterator[Figure]:
    """Yield an empty figure, and save it on success.

    Text is drawn literally and never parsed as mathematics, because names of files and labels may
    contain "$". A logarithmic axis therefore needs `label_decades`, as matplotlib's labels are
    mathematics. All other parameters are those of the user's matplotlibrc; all are restored.

    Args:
        path: The PNG file.
        width: Width, inches.
        height: Height, inches.
        layout: Whether matplotlib finds the margins, which takes as long as drawing; None if not.

    Yields:
        The figure, created without pyplot.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    # Texts read these when they are created; those of ticks are created when the figure is saved.
    literal = matplotlib.rc_context(
        {"text.parse_math": False, "text.usetex": False, "axes.formatter.use_mathtext": False}
    )
    with literal, warnings.catch_warnings():
        warnings.filterwarnings("ignore", _MISSING_GLYPH)
        figure = Figure(figsize=(width, height), dpi=_DPI, layout=layout)
        yield figure
        canvas: Any = FigureCanvasAgg(figure)
        with atomic_write(path) as temporary:
            canvas.print_png(temporary)  # savefig draws all of it twice


def label_decades(axis: Axis) -> None:
    """Label 1, 2 and 5 of each decade of a logarithmic axis, as plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

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
        bands = [(start / rate, (end - start) / rate) for _, start, end in runs[1::2]]
        across = axis.get_xaxis_transform()
        axis.broken_barh(bands, (0, 1), transform=across, color="0.92", zorder=0)
        axis.margins(x=0)
        axis.spines[["top", "right"]].set_visible(False)
    if len(runs) > MOST_NAMED_RUNS:
        return
    figure, top = axes[0].get_figure(root=True), axes[0].get_xaxis_transform()
    assert figure is not None
    width = _SHARE_OF_AXES * figure.get_figwidth()
    for label, start, end in runs:
        middle, share = 0.5 * (start + end) / rate, (end - start) / len(context)
        text = fitting(labels[label], share * width)
        axes[0].text(middle, 1.02, text, transform=top, ha="center", va="bottom")


def fitting(text: str, width: float) -> str:
    """Return a text, cut where in the usual font it would be wider than so many inches."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    points, _, _ = text_to_path.get_text_width_height_descent(text, FontProperties(), False)
    share = 72.0 * width / points if text else 1.0
    return text if share >= 1.0 else f"{text[: max(0, int(share * len(text)) - 2)]}…"
