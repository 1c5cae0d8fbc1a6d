"""The way in: a name or a file becomes a `Motion`."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError, RecordingWarning, UnknownMotionError
from mpma_mj.motions import filtering, motion_file
from mpma_mj.motions.body import ARM_POINTS, check_segments, posture_from_points, segments
from mpma_mj.motions.cleaning import Cleaner
from mpma_mj.motions.findings import Findings
from mpma_mj.motions.labelling import label
from mpma_mj.motions.loop import close_loop
from mpma_mj.motions.markers import Groups, choose_markers, parse_mapping
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length, find_unit, find_up, turn_z_up
from mpma_mj.motions.readers import open_recording
from mpma_mj.motions.recording import UNITS, Recording, Tracks
from mpma_mj.motions.sides import check_sides
from mpma_mj.motions.startup import startup_frames
from mpma_mj.motions.ymca import ymca

__all__ = ["BUILT_IN", "Reading", "read_motion", "read_with_findings"]

Array = NDArray[np.float64]

BUILT_IN = {"ymca": ymca}
_RATE = 20.0  # Hz, of the paper's control step
# Options that a movement which is already one of arms has no use for.
_FOR_RECORDINGS = {
    *("map", "skeleton", "unit", "up", "rate_in", "max_gap", "longest", "repair", "cutoff"),
}
_OF_CONTEXT = ("context", "segments", "labels", "audio")
_DEFAULTS = {field.name: field.default for field in fields(ReadingOptions)}


@dataclass(frozen=True, eq=False)
class Reading:
    """A movement, and what became of its recording on the way.

    Attributes:
        motion: The movement.
        findings: What was found and done.
        format: Kind of the file.
        groups: Which markers show which point of the body.
        names: All points that the file has.
        frames: Number of frames in the file.
        rate: Frames per second of the file, Hz.
        lengths: Mean and standard deviation of each arm segment's length, in m, or in the
            file's unit where that is unknown.
        metric: Whether the lengths are in m.
        times: When each posture was taken, shape (T,), s from the recording's first frame.
        gaps: Stretches that were bridged, by marker, each from and to in such seconds.
    """

    motion: Motion
    findings: Findings
    format: str
    groups: Groups
    names: tuple[str, ...]
    frames: int
    rate: float
    lengths: dict[str, tuple[float, float]]
    metric: bool
    times: Array
    gaps: dict[str, list[tuple[float, float]]]


def read_motion(source: str | Path, *, rate: float = _RATE, **options: Any) -> Motion:
    """Read a movement: a built-in one by name, or a recording by its file.

    What may be wrong with a recording is told by a `RecordingWarning`.

    Args:
        source: "ymca", or the path of a recording: C3D, BVH, ASF/AMC, TRC, Qualisys TSV, a
            table with a header, or npz.
        rate: Postures per second that are wanted, Hz.
        **options: The fields of `ReadingOptions`, such as tempo=0.5 or max_gap=0.3.

    Returns:
        The movement.

    Raises:
        BadOptionError: An option is outside what it may be.
        UnknownMotionError: No built-in movement and no file of that name.
        MotionFileError: The file cannot be read as the movement of two arms.
    """
    known = [field.name for field in fields(ReadingOptions)]
    unknown = [name for name in options if name not in known]
    if unknown:
        raise BadOptionError(f"no option {unknown[0]}; expected {', '.join(known)}")
    reading = read_with_findings(source, ReadingOptions(**options), rate=rate)
    for warning in reading.findings.warnings:
        warnings.warn(f"{source}: {warning}", RecordingWarning, stacklevel=2)
    return reading.motion


def read_with_findings(
    source: str | Path, options: ReadingOptions, *, rate: float = _RATE
) -> Reading:
    """Read a movement, and tell what was found and done.

    Args:
        source: As for `read_motion`.
        options: How to read it.
        rate: Postures per second that are wanted, Hz.

    Raises:
        MpmaError: As for `read_motion`.
    """
    options.check()
    if not (math.isfinite(rate) and rate > 0):
        raise BadOptionError(f"rate is {rate:g}; expected a number above 0")
    findings = Findings()
    if str(source) in BUILT_IN:
        motion = BUILT_IN[str(source)](rate, options.tempo)
        return _as_it_is(motion, "built in", options, findings)
    path = Path(source)
    _check_file(path)
    stored = motion_file.read(path)
    if stored is not None:
        motion = motion_file.at_rate(stored, rate, options.tempo)
        return _as_it_is(motion, "npz", options, findings)
    skeleton = None if options.skeleton is None else Path(options.skeleton)
    recording = open_recording(path, findings, skeleton=skeleton)
    return _read(recording, options, rate, findings)


def _read(
    recording: Recording, options: ReadingOptions, rate: float, findings: Findings
) -> Reading:
    """Read the trajectories of a recording and make a movement of them."""
    path, where = recording.path, str(recording.path)
    mapping = parse_mapping(options.map) if options.map else {}
    groups = choose_markers(path, recording.names, mapping)
    tracks = recording.load(list(dict.fromkeys(n for group in groups.values() for n in group)))
    frames = len(next(iter(tracks.values())))
    if recording.frames not in (None, frames):
        findings.warn(
            f"the file says {recording.frames} frames and holds {frames}; {frames} are used"
        )
    own_rate = _source_rate(recording, options, findings)
    cleaner = Cleaner(tracks, groups, own_rate, where, findings)
    del tracks
    cleaner.clean(options)
    points = cleaner.points()
    up = find_up(points, recording.up, options.up, where, findings)
    for name in list(points):
        points[name] = turn_z_up(points[name], up)
    check_segments(points, where, cleaner.first)
    given = None if options.unit is None else UNITS[options.unit]
    unit = find_unit(arm_length(points), recording.unit, given, findings)
    lengths = {
        name: (float(length.mean()) * (unit or 1.0), float(length.std()) * (unit or 1.0))
        for name, length in ((n, np.linalg.norm(v, axis=1)) for n, v in segments(points).items())
    }
    first = startup_frames(points, own_rate)
    if first:
        findings.note(f"cut {first} frame{'s' * (first > 1)} of a start-up pose")
        points = {name: track[first:] for name, track in points.items()}
    cutoff = _cutoff(points, own_rate, rate, options, findings)
    for name in list(points):
        smooth = filtering.low_pass(points[name], own_rate, cutoff)
        shown = filtering.anti_alias(smooth, own_rate * options.tempo, rate)
        points[name] = filtering.resample(shown, own_rate * options.tempo, rate)
    posture = posture_from_points(points)
    check_sides(points, posture, findings)
    if options.loop and len(posture) > 1:
        posture = close_loop(posture, rate)
    begins = (cleaner.first + first) / own_rate
    times = begins + np.arange(len(posture)) / rate * options.tempo
    context, labels = label(posture, times, recording.spans, options, path, findings)
    source = f"{recording.format} recording {path.name}"
    return Reading(
        Motion(posture, context, labels, rate, path.stem, source, options.tempo),
        findings,
        recording.format,
        cleaner.groups,
        recording.names,
        frames,
        own_rate,
        lengths,
        unit is not None,
        times,
        {n: [(f / own_rate, e / own_rate) for f, e in g] for n, g in cleaner.gaps.items()},
    )


def _as_it_is(motion: Motion, kind: str, options: ReadingOptions, findings: Findings) -> Reading:
    """Return a movement that needs no cleaning, cut and labelled as the options say.

    Raises:
        BadOptionError: An option is given that only the recording of a dancer has a use for.
    """
    for field in fields(ReadingOptions):
        if field.name in _FOR_RECORDINGS and getattr(options, field.name) != field.default:
            raise BadOptionError(
                f"{field.name.replace('_', '-')} is for recordings; {motion.name} is a finished"
                " movement: leave it out"
            )
    times = np.arange(len(motion)) / motion.rate * options.tempo
    end = math.inf if options.end is None else options.end
    kept = np.flatnonzero((times >= (options.start or 0.0)) & (times < end))
    if len(kept) < len(times):
        if not len(kept):
            raise BadOptionError(
                f"from is {options.start or 0:g}, but {motion.name} lasts {times[-1]:.2f} s;"
                " expected less"
            )
        findings.note(f"cut to {times[kept[0]]:g}-{times[kept[-1]]:.2f} s, as asked")
    times, posture = times[kept], motion.posture[kept]
    if options.loop and len(posture) > 1:
        posture = close_loop(posture, motion.rate)
    context, labels = motion.context[kept], motion.labels
    if any(getattr(options, name) != _DEFAULTS[name] for name in _OF_CONTEXT):
        context, labels = label(posture, times, (), options, motion.name, findings)
    motion = replace(motion, posture=posture, context=context, labels=labels)
    return Reading(motion, findings, kind, {}, (), len(motion), motion.rate, {}, True, times, {})


def _source_rate(recording: Recording, options: ReadingOptions, findings: Findings) -> float:
    if options.rate_in is not None:
        told = "no rate" if recording.rate is None else f"{recording.rate:g} Hz"
        findings.note(f"{options.rate_in:g} Hz, as given (the file says {told})")
        return options.rate_in
    if recording.rate is None:
        raise MotionFileError(
            f"{recording.path}: does not say how many frames a second it has; give it with"
            " --rate-in, such as --rate-in 50"
        )
    return recording.rate


def _cutoff(
    points: Tracks, own_rate: float, rate: float, options: ReadingOptions, findings: Findings
) -> float:
    """Return the cut-off frequency of the low-pass filter: as given, or from the data."""
    if options.cutoff is not None:
        cutoff, how = options.cutoff, "as given"
    else:
        start = slice(filtering.looked_at(own_rate))
        arms = np.concatenate([points[name][start] for name in ARM_POINTS], axis=1)
        cutoff, how = filtering.data_cutoff(arms, own_rate), "from the data"
    nothing = cutoff >= 0.5 * own_rate
    done = "no low-pass filter" if nothing else f"low-pass filter at {cutoff:.3g} Hz, {how}"
    findings.note(f"{done}; resampled from {own_rate:g} Hz to {rate:g} Hz")
    return cutoff


def _check_file(path: Path) -> None:
    if not path.exists():
        if path.suffix or len(path.parts) > 1:
            raise UnknownMotionError(f"{path}: no such file; give the path of a recording")
        raise UnknownMotionError(
            f"no motion '{path}'; built in: {', '.join(BUILT_IN)}; or give the path of a recording"
        )
    if path.is_dir():
        raise MotionFileError(f"{path}: is a folder; give the path of a recording in it")
    if not path.is_file():
        raise MotionFileError(f"{path}: is not a file; give the path of a recording")
    if not os.access(path, os.R_OK):
        raise MotionFileError(f"{path}: cannot be read; check its rights")
