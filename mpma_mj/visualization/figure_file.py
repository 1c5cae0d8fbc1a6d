"""Figures as PNG files."""

from __future__ import annotations

import contextlib
import functools
import warnings
from collections.abc import Iterator
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from mpma_mj.utils.atomic_files import write_atomically

__all__ = ["figure_file"]

_DPI = 110
# A character that the font lacks is drawn as a box; the warning's text depends on the version.
_MISSING_GLYPH = r"Glyph \d+|Matplotlib currently does not support"


@contextlib.contextmanager
def figure_file(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Yield an empty figure, and save it on success.

    Text is drawn literally and never parsed as mathematics, because names of files and labels may
    contain "$". A logarithmic axis therefore needs its own formatter, as matplotlib's writes
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
        write_atomically(path, functools.partial(figure.savefig, dpi=_DPI))
