"""The way in: a name or a file becomes a `Motion`."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, MotionFileError, UnknownMotionError
from mpma_mj.motions import motion_file
from mpma_mj.motions.body import ARM_POINTS, check_segments, posture_from_points, segments
from mpma_mj.motions.cleaning import Cleaner, filtering
from mpma_mj.motions.cleaning.calibration_pose import calibration_frames
from mpma_mj.motions.context import label
from mpma_mj.motions.finished import read_finished
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loop import close_loop
from mpma_mj.motions.mapping import parse_mapping
from mpma_mj.motions.marker_sets import choose_markers
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.orientation import arm_length, find_unit, find_up, turn_z_up
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.readers.recording import UNITS, Recording, Tracks
from mpma_mj.motions.reading import Reading
from mpma_mj.motions.sides import check_sides
from mpma_mj.motions.synthetic import DANCES, invented
from mpma_mj.motions.ymca import ymca

__all__ = ["BUILT_IN", "import_motion", "read_motion"]

Array = NDArray[np.float64]

BUILT_IN: dict[str, Callable[[float, float], Motion]] = {
    "ymca": ymca,
    "invented": invented,
    **{f"invented-{n}": functools.partial(invented, dance=n) for n in range(1, DANCES + 1)},
}
_RATE = 20.0  # Hz, of the paper's control step
_BODY = 1.5  # times as many points as the arms need: then there is more of the body (choice)
_MOST_VARIED = 0.15  # of a segment's length; skin markers make 3 % (choice)
_RATES = (1.0, 1000.0)  # Hz: at higher ones a movement fills the memory


def read_motion(source: str | Path, *, rate: float = _RATE, **options: Any) -> Motion:
    """Read a movement: a built-in one by name, or a recording by its file.

    What may be wrong with a recording is told by a `RecordingWarning`.

    Args:
        source: "ymca", "invented", or the path of a recording: C3D, BVH, ASF/AMC, TRC, Qualisys
            TSV, a table with a header, or npz.
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
    reading = import_motion(source, ReadingOptions(**options), rate=rate)
    reading.report.tell(source)
    return reading.motion


def import_motion(source: str | Path, options: ReadingOptions, *, rate: float = _RATE) -> Reading:
    """Read a movement, and tell what was found and done.

    Args:
        source: As for `read_motion`.
        options: How to read it.
        rate: Postures per second that are wanted, Hz.

    Raises:
        MpmaError: As for `read_motion`.
    """
    options.check()
    if not _RATES[0] <= rate <= _RATES[1]:
        expected = f"{_RATES[0]:g} to {_RATES[1]:g} Hz"
        raise BadOptionError(option="rate", value=rate, expected=expected)
    report = ImportReport()
    if str(source) in BUILT_IN:
        motion = BUILT_IN[str(source)](rate, options.tempo)
        return read_finished(motion, "built in", options, report)
    path = Path(source)
    _check_file(path)
    stored = motion_file.read(path)
    if stored is not None:
        motion = motion_file.at_rate(stored, rate, options.tempo)
        return read_finished(motion, "npz", options, report)
    skeleton = None if options.skeleton is None else Path(options.skeleton)
    recording = open_recording(path, report, skeleton=skeleton)
    return _read(recording, options, rate, report)


def _read(
    recording: Recording, options: ReadingOptions, rate: float, report: ImportReport
) -> Reading:
    """Read the trajectories of a recording and make a movement of them."""
    path, where = recording.path, str(recording.path)
    mapping = parse_mapping(options.map) if options.map else {}
    groups = choose_markers(path, recording.names, mapping)
    names = list(dict.fromkeys(name for group in groups.values() for name in group))
    if "pelvis" not in groups and len(recording.names) > _BODY * len(names):
        report.warn(
            "no pelvis is known among its points, so that the torso is taken as upright and a bend"
            " moves the arms",
            remedy='name it with {map="pelvis=…"}',
        )
    own_rate = _source_rate(recording, options, report)
    cleaner = Cleaner(recording.load(names), groups, own_rate, where, report)
    frames = cleaner.frames
    if recording.frames not in (None, frames):
        report.warn(
            f"the file says {recording.frames} frames and holds {frames}; {frames} are used"
        )
    cleaner.clean(options)
    points = cleaner.points()
    up = find_up(points, recording.up, options.up, where, report, cleaner.lost_trunk)
    for name in list(points):
        points[name] = turn_z_up(points[name], up)
    check_segments(points, where, cleaner.first)
    lengths, metric = _measure(points, recording, options, report)
    first = calibration_frames(points, own_rate)
    if first:
        frames_cut = "the first frame is" if first == 1 else f"the first {first} frames are"
        report.warn(f"{frames_cut} cut: a start-up pose")
        points = {name: track[first:] for name, track in points.items()}
    _filter_and_resample(points, own_rate, rate, options, report)
    posture = posture_from_points(points)
    check_sides(points, posture, cleaner.groups, report)
    if len(posture) < 2:
        raise MotionFileError(
            f"{where}: has {len(posture)} posture(s) at {rate:g} Hz; a movement needs at least"
            " two, so record for longer"
        )
    if options.loop:
        posture = close_loop(posture, rate)
    begins = (cleaner.first + first) / own_rate
    times = begins + np.arange(len(posture)) / rate * options.tempo
    context, labels = label(posture, times, recording.spans, options, path, report)
    source = f"{recording.format} recording {path.name}"
    return Reading(
        motion=Motion(posture, context, labels, rate, path.stem, source, options.tempo),
        report=report,
        format=recording.format,
        groups=cleaner.groups,
        names=recording.names,
        frames=frames,
        rate=own_rate,
        lengths=lengths,
        metric=metric,
        times=times,
        gaps={n: [(f / own_rate, e / own_rate) for f, e in g] for n, g in cleaner.gaps.items()},
    )


def _measure(
    points: Tracks, recording: Recording, options: ReadingOptions, report: ImportReport
) -> tuple[dict[str, tuple[float, float]], bool]:
    """Return mean and standard deviation of the segments' lengths, and whether they are in m."""
    given = None if options.unit is None else UNITS[options.unit]
    unit = find_unit(arm_length(points), recording.unit, given, report)
    lengths = {}
    for name, vectors in segments(points).items():
        length = np.linalg.norm(vectors, axis=1) * (unit or 1.0)
        lengths[name] = (float(length.mean()), float(length.std()))
        varies = length.std() / length.mean()
        if varies > _MOST_VARIED:
            report.warn(
                f"the {name}'s length varies by {100 * varies:.0f} %: a marker of it is elsewhere"
                " for part of the time"
            )
    return lengths, unit is not None


def _filter_and_resample(
    points: Tracks, own_rate: float, rate: float, options: ReadingOptions, report: ImportReport
) -> None:
    """Bring points, in place, from their own rate to the one that is wanted, both in Hz."""
    cutoff = _cutoff(points, own_rate, rate, options, report)
    played = own_rate * options.tempo  # frames per second of the movement, Hz
    for name in list(points):
        smooth = filtering.low_pass(points[name], own_rate, cutoff)
        points[name] = filtering.resample(filtering.anti_alias(smooth, played, rate), played, rate)


def _source_rate(recording: Recording, options: ReadingOptions, report: ImportReport) -> float:
    if options.rate_in is not None:
        told = "no rate" if recording.rate is None else f"{recording.rate:g} Hz"
        report.note(f"{options.rate_in:g} Hz, as given (the file says {told})")
        return options.rate_in
    if recording.rate is None:
        raise MotionFileError(
            f"{recording.path}: does not say how many frames a second it has",
            remedy="give it with {rate_in}, such as {rate_in=50}",
        )
    return recording.rate


def _cutoff(
    points: Tracks, own_rate: float, rate: float, options: ReadingOptions, report: ImportReport
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
    report.note(f"{done}; resampled from {own_rate:g} Hz to {rate:g} Hz")
    return cutoff


def _check_file(path: Path) -> None:
    if not path.exists():
        if path.suffix or len(path.parts) > 1:
            raise UnknownMotionError(f"{path}: no such file; give the path of a recording")
        raise UnknownMotionError(
            f"no motion '{path}'; built in: ymca, invented, invented-1 to invented-{DANCES}; or"
            " give the path of a recording"
        )
    if path.is_dir():
        raise MotionFileError(f"{path}: is a folder; give the path of a recording in it")
    if not path.is_file():
        raise MotionFileError(f"{path}: is not a file; give the path of a recording")
    if not os.access(path, os.R_OK):
        raise MotionFileError(f"{path}: cannot be read; check its rights")
