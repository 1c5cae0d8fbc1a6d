"""Context signals: one entry for each label of a motion."""

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
        start: Start, s from the first frame of the recording.
        end: End, s from the first frame of the recording; excluded.
        label: Label; all spans with the same label have the same context.
    """

    start: float
    end: float
    label: str


def one_hot(index: NDArray[np.int_], size: int) -> Array:
    """Return the context that is 1 for one label and 0 for all others.

    Args:
        index: Index of the active label, shape (T,).
        size: Number of labels, C.

    Returns:
        Context, shape (T, C).
    """
    return np.eye(size)[index]


def equal_segments(frames: int, segments: int) -> tuple[Array, tuple[str, ...]]:
    """Label a motion without labels by segments of equal length.

    Args:
        frames: Number of postures, T.
        segments: Number of segments, C.

    Returns:
        Context, shape (T, C), and the labels "1" to "C".
    """
    index = np.arange(frames) * segments // frames
    return one_hot(index, segments), tuple(str(i + 1) for i in range(segments))


def context_of_spans(spans: Iterable[Span], times: Array) -> tuple[Array, tuple[str, ...]]:
    """Return the context of labelled spans.

    Where spans overlap all their labels are 1; outside all spans the context is 0. Labels without
    a posture are left out.

    Args:
        spans: The spans.
        times: Time of each posture, shape (T,), s from the first frame of the recording.

    Returns:
        Context, shape (T, C), and its labels in the order in which they first occur; C is 0 if no
        span contains a posture.
    """
    active: dict[str, NDArray[np.bool_]] = {}
    for span in sorted(spans, key=lambda span: (span.start, span.end)):
        inside = (span.start <= times) & (times < span.end)
        if inside.any():
            active[span.label] = active.get(span.label, np.zeros(len(times), bool)) | inside
    return np.array([*active.values()], np.float64).reshape(-1, len(times)).T, tuple(active)


def active_label(context: Array) -> NDArray[np.int_]:
    """Return the index of the active label at each step.

    Args:
        context: Context, shape (T, C).

    Returns:
        Index of the largest entry, the first of equal ones, shape (T,); -1 where all are 0.
    """
    return np.where(context.any(axis=1), context.argmax(axis=1), -1)
