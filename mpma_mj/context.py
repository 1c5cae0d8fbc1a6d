"""Context signals: what a dancer hears while dancing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Span", "active_label", "context_of_spans", "equal_segments", "one_hot"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Span:
    """A stretch of time with a label.

    Attributes:
        start: Where it begins, s from the recording's first frame.
        end: Where it ends, s; the end itself no longer belongs to it.
        label: Its name. Spans of one name are the same context, wherever they lie.
    """

    start: float
    end: float
    label: str


def one_hot(index: NDArray[np.int_], size: int) -> Array:
    """Return the context that is 1 at one label and 0 elsewhere.

    Args:
        index: Which label is danced, shape (T,).
        size: Number of labels, C.

    Returns:
        Context, shape (T, C).
    """
    return np.eye(size)[index]


def equal_segments(frames: int, segments: int) -> tuple[Array, tuple[str, ...]]:
    """Label a movement that has no labels of its own by parts of equal length.

    Args:
        frames: Number of postures, T.
        segments: Number of parts, C.

    Returns:
        Context, shape (T, C), and the labels "1" to "C".
    """
    index = np.arange(frames) * segments // frames
    return one_hot(index, segments), tuple(str(i + 1) for i in range(segments))


def context_of_spans(spans: Iterable[Span], times: Array) -> tuple[Array, tuple[str, ...]]:
    """Make the context of labelled stretches of time.

    Where spans overlap all their labels are 1, where there is none all are 0. A label that
    no posture falls into is left out.

    Args:
        spans: The stretches.
        times: When each posture is taken, shape (T,), s from the recording's first frame.

    Returns:
        Context, shape (T, C), and its labels in the order in which they are first heard; C is 0
        where no span covers a posture.
    """
    heard: dict[str, NDArray[np.bool_]] = {}
    for span in sorted(spans, key=lambda span: (span.start, span.end)):
        inside = (span.start <= times) & (times < span.end)
        if inside.any():
            heard[span.label] = heard.get(span.label, np.zeros(len(times), bool)) | inside
    return np.array([*heard.values()], np.float64).reshape(-1, len(times)).T, tuple(heard)


def active_label(context: Array) -> NDArray[np.int_]:
    """Return which label is danced.

    Args:
        context: Context, shape (T, C).

    Returns:
        Index of the largest entry, the first of equal ones, shape (T,); -1 where all are 0.
    """
    return np.where(context.any(axis=1), context.argmax(axis=1), -1)
