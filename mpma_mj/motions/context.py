"""Context signals: what a dancer hears while dancing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["equal_segments", "one_hot"]


def one_hot(index: NDArray[np.int_], size: int) -> NDArray[np.float64]:
    """Return the context that is 1 at one label and 0 elsewhere.

    Args:
        index: Which label is danced, shape (T,).
        size: Number of labels, C.

    Returns:
        Context, shape (T, C).
    """
    return np.eye(size)[index]


def equal_segments(frames: int, segments: int) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Label a movement that has no labels of its own by parts of equal length.

    Args:
        frames: Number of postures, T.
        segments: Number of parts, C.

    Returns:
        Context, shape (T, C), and the labels "1" to "C".
    """
    index = np.arange(frames) * segments // frames
    return one_hot(index, segments), tuple(str(i + 1) for i in range(segments))
