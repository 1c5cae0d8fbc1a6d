"""Loading of motions: a name or a file becomes a `Motion`, with a report of its import."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mpma_mj.errors import (
    BadOptionError,
    InfeasibleMotionError,
    MotionFileError,
    UnknownMotionError,
)
from mpma_mj.motions.body import ARM_POINTS, has_trunk, posture_from_points
from mpma_mj.motions.built_in import built_in, unknown_motion
from mpma_mj.motions.cleaning import clean
from mpma_mj.motions.cleaning.trajectories import Trajectories
from mpma_mj.motions.context import label_motion
from mpma_mj.motions.feasibility import JointLimits
from mpma_mj.motions.feasible_motion import feasible, feasible_tempo
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import TRUNK_OPTION, parse_mapping
from mpma_mj.motions.marker_sets import choose_markers, facing_markers, unrecognised
from mpma_mj.motions.motion import Motion, load_motion
from mpma_mj.motions.options import ReadingOptions, given
from mpma_mj.motions.orientation import check_handedness, check_sides
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.readers.recording import Recording, unknown_rate
from mpma_mj.motions.readers.tables.joint_angles import read_joint_angles
from mpma_mj.motions.transforms import at_rate, close_loop
from mpma_mj.utils.input_files import FOLDER, MISSING, file_problem

__all__ = ["ImportedMotion", "import_motion", "read_motion", "refuse_run"]

_RATE = 20.0  # Hz, of the paper's control step
_RATES = (1.0, 1000.0)  # Hz: at higher ones a motion fills the memory
# Options for which a motion of arms, built in or stored, has no use.
_FOR_RECORDINGS = {
    *("map", "skeleton", "unit", "up", "left_handed", "rate_in", "max_gap", "longest", "repair"),
    *("other_arm", "depth", "cutoff"),
}
_OF_CONTEXT = {"context", "segments", "labels", "audio"}


class ImportedMotion(NamedTuple):
    """A motion and the report of its import."""

    motion: Motion
    report: ImportReport


def read_motion(
    source: str | Path,
    *,
    rate: float = _RATE,
    limits: JointLimits | None = None,
    **options: Any,
) -> Motion:
    """Read a motion: a built-in one by name, or a recording by its file.

    A `RecordingWarning` is issued for everything that may be wrong with a recording.

    Args:
        source: A name of `BUILT_IN` such as "ymca", "semaphore:WORD", or the path of a recording:
            C3D, BVH, ASF/AMC, TRC, Qualisys TSV, MVNX, a table with a header, JSON, npy, npz, or a
            video.
        rate: Requested postures per second, Hz.
        limits: Limits of the arms that are to follow it, as `arm_limits` returns them; then the
            motion is made feasible (see `feasible`), or refused with strict=True. If not given, an
            environment does so later.
        **options: The fields of `ReadingOptions`, such as tempo=0.5 or max_gap=0.3.

    Returns:
        The motion.

    Raises:
        BadOptionError: An option is outside what it may be.
        UnknownMotionError: No built-in motion and no file of that name.
        MotionFileError: The file cannot be read as the motion of two arms.
    """
    known = [field.name for field in fields(ReadingOptions)]
    unknown = [name for name in options if name not in known]
    if unknown:
        raise BadOptionError(f"no option {unknown[0]}; expected {', '.join(known)}")
    motion, report = import_motion(source, ReadingOptions(**options), rate=rate, limits=limits)
    report.emit_warnings(source)
    return motion


def import_motion(
    source: str | Path,
    options: ReadingOptions,
    *,
    rate: float = _RATE,
    limits: JointLimits | None = None,
) -> ImportedMotion:
    """Read a motion, and report what was found and done.

    Args:
        source: As for `read_motion`.
        options: How to read it.
        rate: Requested postures per second, Hz.
        limits: As for `read_motion`; options `strict` and `tempo="auto"` need them.

    Raises:
        InfeasibleMotionError: The arms cannot follow the motion, and `strict` is given; or they
            cannot at any tempo that is looked for.
        MpmaError: As for `read_motion`.
    """
    options.check()
    if not _RATES[0] <= rate <= _RATES[1]:
        expected = f"{_RATES[0]:g} to {_RATES[1]:g} Hz"
        raise BadOptionError(option="rate", value=rate, expected=expected)
    if limits is None:
        if options.strict or options.tempo == "auto":
            needy = "strict" if options.strict else "tempo=auto"
            raise BadOptionError(
                f"the limits of the arms are needed for {needy}",
                remedy="give them with {limits=mpma_mj.arm_limits()}",
            )
        return _import(source, options, rate)
    if options.tempo == "auto":
        try:
            tempo = feasible_tempo(lambda t: _at_tempo(source, options, rate, t).motion, limits)
        except InfeasibleMotionError as error:
            raise error.with_context(source) from None
        imported = _at_tempo(source, options, rate, tempo)
        imported.report.note(f"tempo {tempo:g}, at which the arms can follow it")
    else:
        imported = _import(source, options, rate)
    motion, change = feasible(imported.motion, limits)
    if change is not None and options.strict:
        remedy = f"{change.remedy}; leave out {{strict}}" if change.remedy else "leave out {strict}"
        raise InfeasibleMotionError(f"{source}: {change}", remedy=remedy)
    if change is not None:
        imported.report.warn(str(change), remedy=change.remedy or "{strict} refuses such a motion")
    return ImportedMotion(motion, imported.report)


def _at_tempo(
    source: str | Path, options: ReadingOptions, rate: float, tempo: float
) -> ImportedMotion:
    return _import(source, replace(options, tempo=tempo), rate)


def _import(source: str | Path, options: ReadingOptions, rate: float) -> ImportedMotion:
    """Read a motion as it is, whether arms can follow it or not; see `import_motion`."""
    report = ImportReport()
    tempo = options.own_tempo
    if make := built_in(source):
        return _import_arms(make(rate, tempo), "built in", options, report)
    _check_file(source)
    path = Path(source)
    stored = load_motion(path)
    if stored is not None:
        return _import_arms(at_rate(stored, rate, tempo), "npz", options, report)
    angles = read_joint_angles(path, options.rate_in, report)
    if angles is not None:
        motion, of_arms = at_rate(angles, rate, tempo), replace(options, rate_in=None)
        return _import_arms(motion, "joint angles", of_arms, report, labelled=False)
    return _import_recording(open_recording(path, report, options), options, rate, report)


def _import_recording(
    recording: Recording, options: ReadingOptions, rate: float, report: ImportReport
) -> ImportedMotion:
    """Clean the trajectories of a recording and make a motion of them."""
    path = recording.path
    mapping = parse_mapping(options.map) if options.map else {}
    groups = choose_markers(
        path,
        recording.names,
        mapping,
        report,
        one_arm=options.other_arm is not None,
        root=recording.root,
    )
    names = list(dict.fromkeys(name for group in groups.values() for name in group))
    others = "" if has_trunk(groups) else unrecognised(recording.names, groups)
    if not has_trunk(groups):
        _warn_of_no_trunk(others, report)
    own_rate = _source_rate(recording, options, report)
    facing = facing_markers(recording.names, groups)
    tracks = recording.load(list(dict.fromkeys((*names, *facing["front"], *facing["back"]))))
    doubted = check_handedness(tracks, groups, facing, options, report)
    needed = {name: tracks[name] for name in names}
    trajectories = Trajectories(needed, groups, own_rate, rate, recording, others=others)
    del tracks, needed  # long recordings: cleaning drops each marker after its last use
    report.format, report.names = recording.format, recording.names
    report.rate, report.frames = own_rate, trajectories.frames
    if recording.frames not in (None, report.frames):
        report.warn(
            f"the file declares {recording.frames} frames but contains {report.frames}, which are"
            " used"
        )
    clean(trajectories, options, report)
    report.groups = trajectories.groups
    posture = posture_from_points(trajectories.tracks)
    if groups.keys() >= set(ARM_POINTS) and not doubted:
        check_sides(trajectories.tracks, posture, trajectories.groups, report)
    if len(posture) < 2:
        raise MotionFileError(
            f"{path}: has {len(posture)} posture(s) at {rate:g} Hz; a motion needs at least two;"
            " record for longer"
        )
    if options.loop:
        posture = close_loop(posture, rate)
    begins = trajectories.first / own_rate
    report.times = begins + np.arange(len(posture)) / rate * options.own_tempo
    context, labels = label_motion(posture, report.times, recording.spans, options, path, report)
    source = f"{recording.format} recording {path.name}"
    tempo = options.own_tempo
    motion = Motion(
        posture, context, labels, rate, path.stem, source, tempo, float(report.times[0])
    )
    return ImportedMotion(motion, report)


def _import_arms(
    motion: Motion,
    kind: str,
    options: ReadingOptions,
    report: ImportReport,
    *,
    labelled: bool = True,
) -> ImportedMotion:
    """Cut, close and label a motion of arms, built in or stored, as the options require.

    Args:
        motion: The motion, at the requested rate and tempo.
        kind: What the report calls its format.
        options: How to read it.
        report: Gets what is done.
        labelled: Whether the motion has labels of its own, which it keeps by default.

    Raises:
        BadOptionError: An option is given that applies only to recordings, or
            nothing is left of the motion.
    """
    useless = given(options) & _FOR_RECORDINGS
    if useless:
        raise BadOptionError(
            f"{motion.name} is a complete motion",
            remedy=f"leave out {{{min(useless)}}}, which is for recordings",
        )
    times = motion.start + np.arange(len(motion)) / motion.rate * options.own_tempo
    start, end = options.start or 0.0, math.inf if options.end is None else options.end
    if start >= times[-1]:
        expected = f"less, as {motion.name} lasts {times[-1]:.2f} s"
        raise BadOptionError(option="start", value=start, expected=expected)
    kept = (times >= start) & (times < end)
    if kept.sum() < 2:
        raise BadOptionError(
            f"{motion.name} has {kept.sum()} posture(s) from {start:g} to"
            f" {min(end, times[-1]):g} s; give a longer time"
        )
    if options.end is not None and end > times[-1] + 1.0 / motion.rate:
        report.warn(
            f"{motion.name} ends at {times[-1]:.2f} s", remedy=f"{{end={end:g}}} is later than that"
        )
    if not kept.all():
        report.note(f"cut to {times[kept][0]:g}-{times[kept][-1]:.2f} s, as requested")
    report.format, report.frames, report.rate = kind, len(motion), motion.rate
    report.times, posture, context = times[kept], motion.posture[kept], motion.context[kept]
    if options.loop:
        posture = close_loop(posture, motion.rate)
    if given(options) & _OF_CONTEXT or not labelled:
        context, labels = label_motion(posture, report.times, (), options, motion.name, report)
    else:
        # Labels whose frames were all cut off are left out.
        present = np.flatnonzero(context.any(axis=0) | ~motion.context.any(axis=0))
        context, labels = context[:, present], tuple(motion.labels[i] for i in present)
    angles = motion.feasible_angles
    if angles is not None:
        angles = None if options.loop else angles[kept]
    motion = replace(
        motion,
        posture=posture,
        context=context,
        labels=labels,
        start=float(report.times[0]),
        feasible_angles=angles,
    )
    return ImportedMotion(motion, report)


def _warn_of_no_trunk(others: str, report: ImportReport) -> None:
    """Warn of points that show no trunk; others are those that are not recognised."""
    if others:
        report.warn(
            "no point is recognised as the pelvis, so that the torso is assumed to be upright and"
            f" bending moves the arms; not recognised are {others}",
            remedy=f"name pelvis and neck with {TRUNK_OPTION}",
        )
    else:
        report.warn("has no points of the trunk, so that the torso is assumed to be upright")


def _source_rate(recording: Recording, options: ReadingOptions, report: ImportReport) -> float:
    if options.rate_in is not None:
        report.settle("rate_in")
        declared = "no rate" if recording.rate is None else f"{recording.rate:g} Hz"
        report.note(f"{options.rate_in:g} Hz, as given (the file declares {declared})")
        return options.rate_in
    if recording.rate is None:
        raise unknown_rate(recording.path, report)
    return recording.rate


def refuse_run(folder: Path) -> None:
    """Refuse the folder of a run in place of a motion.

    Raises:
        MotionFileError: It is one.
    """
    if (folder / "config.json").exists() and (folder / "metrics.csv").exists():
        raise MotionFileError(
            f"{folder}: is a run, not a motion",
            remedy="mpma imitate continues it with {resume}, or begins from it with {init}, and"
            " mpma play shows it",
        )


def _check_file(source: str | Path) -> None:
    if not isinstance(source, str | Path):
        raise BadOptionError(
            option="source", value=source, expected="the name of a motion, or a path"
        )
    problem, path = file_problem(source), Path(source)
    if problem == FOLDER:
        refuse_run(path)
    if problem == MISSING and not path.suffix and len(path.parts) == 1:
        raise unknown_motion(path)
    if problem:
        raise (UnknownMotionError if problem == MISSING else MotionFileError)(
            f"{source}: {problem}"
        )
