"""Context of a motion: from labels, events, audio, changes of the motion, or equal parts."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.context import Span, context_of_spans, equal_segments, one_hot
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions import audio_segments
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.cells import is_number
from mpma_mj.motions.readers.text import TextFile
from mpma_mj.utils.input_files import SMALL_FILE, file_problem
from mpma_mj.utils.text import listing

__all__ = ["change_points", "label_motion", "read_labels"]

Array = NDArray[np.float64]

_MOST_LISTED = 30
_MOST_POSTURES = 2000  # that are compared, as the time grows with their square (choice)
_VELOCITY_WEIGHT = 0.6  # against posture's 1; more of it takes holds for parts (choice)
_SHORTEST = 4  # times a part may be shorter than if all were equal (choice)


def label_motion(
    posture: Array,
    times: Array,
    events: Sequence[Span],
    options: ReadingOptions,
    where: str | Path,
    report: ImportReport,
) -> tuple[Array, tuple[str, ...]]:
    """Return the context of a motion.

    Args:
        posture: Postures, shape (T, 12).
        times: When each was taken, shape (T,), s from the recording's first frame.
        events: Labelled stretches of the recording.
        options: Where the labels come from.
        where: What an error calls the recording.
        report: Gets a line about the context.

    Returns:
        Context, shape (T, C), and its labels.

    Raises:
        BadOptionError: There are more parts than postures.
        MotionFileError: The file, recording or audio has no labels for the motion.
    """
    spans = _spans(events, options, where)
    if spans is not None:
        context, labels = context_of_spans(spans, times)
        if not labels:
            raise MotionFileError(
                f"{options.labels or options.audio or where}: no label lies between {times[0]:.2f}"
                f" and {times[-1]:.2f} s, the time of the motion; times of labels count from the"
                " recording's first frame"
            )
        silent = float(np.mean(context.sum(axis=1) == 0))
        if silent:
            report.warn(f"{100 * silent:.0f} % of the motion has no label; its context is 0")
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
        index = change_points(posture, options.segments)
        starts = times[np.flatnonzero(np.diff(index)) + 1]
        report.note(f"the motion changes at {_listed(starts)} s")
        return one_hot(index, options.segments), tuple(str(i + 1) for i in range(options.segments))
    return equal_segments(len(posture), options.segments)


def _spans(
    events: Sequence[Span], options: ReadingOptions, where: str | Path
) -> Sequence[Span] | None:
    """Return the labelled stretches; None where the motion is to be divided instead."""
    if options.labels is not None:
        return read_labels(Path(options.labels))
    if options.audio is not None:
        find = audio_segments.sections if options.context == "sections" else audio_segments.bars
        return find(Path(options.audio))
    if options.context == "events":
        if not events:
            raise MotionFileError(
                f"{where}: has no events", remedy="label the motion with {labels} or {segments}"
            )
        return events
    return None


def _listed(times: Iterable[float]) -> str:
    return listing([f"{time:.2f}" for time in times], _MOST_LISTED)


def read_labels(path: Path) -> tuple[Span, ...]:
    """Read rows of `start,end,label`, in seconds from the recording's first frame.

    A first row that is no numbers is a header. Spans may overlap; a comma, a semicolon or a tab
    is between cells.

    Raises:
        MotionFileError: The file cannot be read, or a row is not as it should be; names the
            line.
    """
    if problem := file_problem(path, largest=SMALL_FILE):
        raise MotionFileError(f"{path}: {problem}")
    file = TextFile.open(path)
    if file is None:
        raise MotionFileError(
            f"{path}: is not a text file; expected rows of start,end,label in seconds"
        )
    spans = []
    for number, line in enumerate(file.lines(), 1):
        cells = _cells(line)
        numbers = [is_number(cell) for cell in cells[:2]]
        if not any(cells) or (number == 1 and not any(numbers)):
            continue
        if len(cells) != 3 or not all(numbers) or not cells[2]:
            raise MotionFileError(
                f"{path}: line {number}: '{line[:60]}' is not start,end,label, such as 0,2.5,Y"
            )
        start, end = map(float, cells[:2])
        if not (math.isfinite(start) and start < end):
            raise MotionFileError(
                f"{path}: line {number}: the span from {start:g} to {end:g} s has no length;"
                " expected an end after its start"
            )
        spans.append(Span(start, end, cells[2]))
    if not spans:
        raise MotionFileError(f"{path}: contains no rows of start,end,label")
    return tuple(spans)


def _cells(line: str) -> list[str]:
    """Return the cells of a row, with points for decimal commas, by the separator that fits."""
    found = [line]
    for separator in ",;\t":
        try:
            cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
        except csv.Error:  # such as a cell of more than 131072 letters
            continue
        cells[:2] = [cell.replace(",", ".") for cell in cells[:2]]
        if len(cells) == 3 and all(map(is_number, cells[:2])):
            return cells
        if len(cells) > 1:
            found = cells
    return found


def change_points(posture: Array, segments: int) -> NDArray[np.int_]:
    """Cut a motion into parts where it changes.

    Of all ways to cut, that one is taken in which postures and velocities within parts are most
    alike, measured by a Gaussian kernel (Arlot, Celisse & Harchaoui 2019, JMLR 20(162)). It
    puts a change in the middle of a move; a part begins with the move instead, at the last
    minimum of speed before.

    Args:
        posture: Postures in the order of time, shape (T, 12), four unit vectors.
        segments: Number of parts, C.

    Returns:
        Part of each posture, shape (T,), from 0 to C - 1, none of them left out.

    Raises:
        BadOptionError: `segments` is below 1, or more than the postures can distinguish.
    """
    if segments < 1:
        raise BadOptionError(option="segments", value=segments, expected="at least 1")
    frames = len(posture)
    step = max(1, -(-frames // _MOST_POSTURES))
    starts = np.arange(0, frames, step)  # (N,)
    if segments > len(starts):
        raise BadOptionError(
            option="segments",
            value=segments,
            expected=f"at most {len(starts)}, as the motion has {frames} postures",
        )
    if segments == 1:
        return np.zeros(frames, np.int_)
    velocity = np.diff(posture, axis=0, prepend=posture[:1])  # per posture, not per second
    features = _features(_means(posture, starts), _means(velocity, starts))
    cuts = starts[_cuts(features, segments)]
    speed = np.linalg.norm(velocity, axis=1)
    return np.repeat(np.arange(segments), np.diff([*_back_to_rest(cuts, speed), frames]))


def _means(values: Array, starts: NDArray[np.int_]) -> Array:
    """Return the means of stretches, shape (N, 12), of values, shape (T, 12)."""
    lengths = np.diff([*starts, len(values)])
    return np.add.reduceat(values, starts, axis=0) / lengths[:, None]


def _features(posture: Array, velocity: Array) -> Array:
    """Return posture and velocity side by side, scaled to a comparable spread, shape (N, 24)."""
    spread, speed = (np.sqrt(np.var(x, axis=0).sum()) for x in (posture, velocity))
    weight = _VELOCITY_WEIGHT * spread / speed if speed > 0 else 0.0
    return np.concatenate([posture, weight * velocity], axis=1)


def _cuts(features: Array, segments: int) -> NDArray[np.int_]:
    """Return where each part begins, shape (C,), for features of shape (N, 24)."""
    from ruptures import KernelCPD  # takes a second

    shortest = max(1, len(features) // (_SHORTEST * segments))
    found = KernelCPD(kernel="rbf", min_size=shortest).fit_predict(features, n_bkps=segments - 1)
    return np.array([0, *found[:-1]])


def _back_to_rest(cuts: NDArray[np.int_], speed: Array) -> list[int]:
    """Move each cut, shape (C,), back to the minimum of speed, shape (T,), before it."""
    moved = [0]
    for cut in cuts[1:].tolist():
        while cut - 1 > moved[-1] and speed[cut - 1] < speed[cut]:
            cut -= 1
        moved.append(cut)
    return moved
