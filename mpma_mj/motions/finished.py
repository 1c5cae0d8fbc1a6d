"""Movements that are already those of arms: built in, or stored by `motion_file`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mpma_mj.errors import BadOptionError
from mpma_mj.motions.context import label
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loop import close_loop
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.options import ReadingOptions, given
from mpma_mj.motions.reading import Reading

__all__ = ["FOR_RECORDINGS", "read_finished"]

FOR_RECORDINGS = {
    *("map", "skeleton", "unit", "up", "rate_in", "max_gap", "longest", "repair", "cutoff"),
}
"""Options for which a movement of arms has no use."""
_OF_CONTEXT = {"context", "segments", "labels", "audio"}


def read_finished(
    motion: Motion, kind: str, options: ReadingOptions, report: ImportReport
) -> Reading:
    """Cut, close and label a movement as the options say.

    Args:
        motion: The movement, at the wanted rate and tempo.
        kind: What the reading calls its format.
        options: How to read it.
        report: Is told what is done.

    Raises:
        BadOptionError: An option is given that only a recording of a dancer has a use for, or
            nothing is left of the movement.
    """
    useless = given(options) & FOR_RECORDINGS
    if useless:
        raise BadOptionError(
            f"{motion.name} is a finished movement",
            remedy=f"leave out {{{min(useless)}}}, which is for recordings",
        )
    times = np.arange(len(motion)) / motion.rate * options.tempo
    start, end = options.start or 0.0, math.inf if options.end is None else options.end
    kept = (times >= start) & (times < end)
    if kept.sum() < 2:
        raise BadOptionError(
            f"from {start:g} to {end:g} s {motion.name}, which lasts {times[-1]:.2f} s, has"
            f" {kept.sum()} postures; expected a longer time"
        )
    if options.end is not None and end > times[-1] + 1.0 / motion.rate:
        report.warn(
            f"{motion.name} ends at {times[-1]:.2f} s", remedy=f"{{end={end:g}}} asks for more"
        )
    if not kept.all():
        report.note(f"cut to {times[kept][0]:g}-{times[kept][-1]:.2f} s, as requested")
    times, posture, context = times[kept], motion.posture[kept], motion.context[kept]
    if options.loop:
        posture = close_loop(posture, motion.rate)
    if given(options) & _OF_CONTEXT:
        context, labels = label(posture, times, (), options, motion.name, report)
    else:
        # Labels whose frames were all cut off are left out.
        present = np.flatnonzero(context.any(axis=0) | ~motion.context.any(axis=0))
        context, labels = context[:, present], tuple(motion.labels[i] for i in present)
    return Reading(
        motion=replace(motion, posture=posture, context=context, labels=labels),
        report=report,
        format=kind,
        groups={},
        names=(),
        frames=len(motion),
        rate=motion.rate,
        lengths={},
        metric=True,
        times=times,
        gaps={},
    )
