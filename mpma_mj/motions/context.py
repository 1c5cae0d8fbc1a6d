"""Which context goes with a movement."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import Span, context_of_spans, equal_segments, one_hot
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions

__all__ = ["label"]

Array = NDArray[np.float64]

_MOST_LISTED = 30


def label(
    posture: Array,
    times: Array,
    events: Sequence[Span],
    options: ReadingOptions,
    where: str | Path,
    report: ImportReport,
) -> tuple[Array, tuple[str, ...]]:
    """Return the context of a movement.

    Args:
        posture: Postures, shape (T, 12).
        times: When each was taken, shape (T,), s from the recording's first frame.
        events: Labelled stretches that the recording has.
        options: Says where the labels come from.
        where: What an error calls the recording.
        report: Is told about the context.

    Returns:
        Context, shape (T, C), and its labels.

    Raises:
        BadOptionError: There are more parts than postures.
        MotionFileError: There are no labels where they should come from.
    """
    spans = _spans(events, options, where)
    if spans is not None:
        context, labels = context_of_spans(spans, times)
        if not labels:
            raise MotionFileError(
                f"{options.labels or options.audio or where}: no label falls between"
                f" {times[0]:.2f} and {times[-1]:.2f} s, where the movement is; times count from"
                " the recording's first frame"
            )
        silent = float(np.mean(context.sum(axis=1) == 0))
        if silent:
            report.warn(f"{100 * silent:.0f} % of the movement has no label; its context is 0")
        begin = [span.start for span in spans if times[0] < span.start <= times[-1]]
        report.note(
            f"{len(labels)} label{'s' * (len(labels) != 1)}, which begin at {_listed(begin)} s"
            if begin
            else f"one label throughout: {labels[0]}"
        )
        return context, labels
    if options.segments > len(posture):
        raise BadOptionError(
            option="segments",
            value=options.segments,
            expected=f"fewer, as {where} gives {len(posture)} postures",
        )
    if options.context == "changes":
        from mpma_mj.motions.changes import change_points

        index = change_points(posture, options.segments)
        starts = times[np.flatnonzero(np.diff(index)) + 1]
        report.note(f"the movement changes at {_listed(starts)} s")
        return one_hot(index, options.segments), tuple(str(i + 1) for i in range(options.segments))
    return equal_segments(len(posture), options.segments)


def _spans(
    events: Sequence[Span], options: ReadingOptions, where: str | Path
) -> Sequence[Span] | None:
    """Return the labelled stretches; None where the movement is to be divided instead."""
    if options.labels is not None:
        from mpma_mj.motions.label_file import read_labels

        return read_labels(Path(options.labels))
    if options.audio is not None:
        from mpma_mj.motions import audio_segments

        find = audio_segments.sections if options.context == "sections" else audio_segments.bars
        return find(Path(options.audio))
    if options.context == "events":
        if not events:
            raise MotionFileError(
                f"{where}: has no events", remedy="label it with {labels} or {segments}"
            )
        return events
    return None


def _listed(times: Iterable[float]) -> str:
    listed = [f"{time:.2f}" for time in times]
    more = f" and {len(listed) - _MOST_LISTED} more" if len(listed) > _MOST_LISTED else ""
    return ", ".join(listed[:_MOST_LISTED]) + more
