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
# An empty box stands for a character that the font lacks; the words differ between versions.
_MISSING_GLYPH = r"Glyph \d+|Matplotlib currently does not support"


@contextlib.contextmanager
def figure_file(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Give an empty figure, which becomes the file where all went well.

    Text is drawn as it is, never parsed as mathematics: names of files and labels may hold "$".
    So a logarithmic axis needs a formatter, as matplotlib's writes its numbers as mathematics. All
    else is as the user's matplotlibrc has it, and its settings are afterwards what they were.

    Args:
        path: The PNG file.
        width: Width, inches.
        height: Height, inches.

    Yields:
        The figure, made without pyplot.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    # Texts read these when they are made, and those of ticks are not made before it is saved.
    literal = matplotlib.rc_context(
        {"text.parse_math": False, "text.usetex": False, "axes.formatter.use_mathtext": False}
    )
    with literal, warnings.catch_warnings():
        warnings.filterwarnings("ignore", _MISSING_GLYPH)
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        write_atomically(path, functools.partial(figure.savefig, dpi=_DPI))
