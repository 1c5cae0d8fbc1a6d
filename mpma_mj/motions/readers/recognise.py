"""Recognition of file formats by content: which reader a file is for."""

from __future__ import annotations

import io
import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers import (
    acclaim,
    bvh,
    c3d,
    joint_arrays,
    landmarks,
    mvnx,
    npz,
    qualisys,
    smpl,
    trc,
)
from mpma_mj.motions.readers.foreign_formats import refuse_foreign
from mpma_mj.motions.readers.recording import RATES, Recording
from mpma_mj.motions.readers.tables.table import read_table
from mpma_mj.motions.readers.text import TextFile
from mpma_mj.motions.readers.video import reader as video
from mpma_mj.motions.readers.video.frames import is_video

__all__ = ["TEXT_FORMATS", "open_recording"]

TextReader = Callable[[TextFile, ImportReport], Recording]

TEXT_FORMATS: dict[Callable[[list[str]], bool], TextReader] = {
    bvh.is_bvh: bvh.read_bvh,
    trc.is_trc: trc.read_trc,
    qualisys.is_qualisys: qualisys.read_qualisys,
    mvnx.is_xml: mvnx.read_mvnx,
    landmarks.is_json: landmarks.read_landmarks,
}
"""Readers of text, each by what recognises its format by the first lines of a file."""

_WITH_SKELETON = ("ASF/AMC", smpl.FORMAT)
_HEAD = 1 << 16  # bytes that identify the format of a file, whose lines may be long
_LINES = 40  # of a text file
_DEFAULT = ReadingOptions()


def open_recording(
    path: Path, report: ImportReport, options: ReadingOptions = _DEFAULT
) -> Recording:
    """Read the header of a recording of any known format.

    Args:
        path: The file.
        report: Gets what is odd.
        options: How to read it: its skeleton, and of a video the depth and the time.

    Raises:
        BadOptionError: An option is given that is for other formats.
        MotionFileError: The file cannot be read as a recording.
    """
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
        recording = _open(path, head, report, options)
    except OSError as error:
        raise MotionFileError(f"{path}: cannot be read ({error.strerror or error})") from None
    if options.skeleton is not None and recording.format not in _WITH_SKELETON:
        raise BadOptionError(
            f"{path}: is {recording.format}",
            remedy="leave out {skeleton}, which is for AMC and SMPL poses",
        )
    if options.depth != _DEFAULT.depth and recording.format != video.FORMAT:
        raise BadOptionError(
            f"{path}: is {recording.format}", remedy="leave out {depth}, which is for videos"
        )
    if recording.rate is not None and not RATES[0] <= recording.rate <= RATES[1]:
        report.warn(f"{recording.rate:g} Hz, as the file declares, is impossible; it is not used")
        recording = replace(recording, rate=None)
    if not recording.names:
        raise MotionFileError(f"{path}: names no point at all; export the recording with names")
    return recording


def _open(path: Path, head: bytes, report: ImportReport, options: ReadingOptions) -> Recording:
    skeleton = None if options.skeleton is None else Path(options.skeleton)
    if not head.strip():
        raise MotionFileError(f"{path}: is empty; export the recording again")
    if is_video(head):
        return video.read_video(path, options, report)
    refuse_foreign(path, head)
    if npz.is_archive(head):
        return npz.read_arrays(path, npz.read_archive(path), report, skeleton)
    if joint_arrays.is_npy(head):
        return joint_arrays.read_npy(path, report)
    if c3d.is_c3d(head):
        return c3d.read_c3d(path, report)
    text = TextFile.open(path)
    if text is None:
        raise MotionFileError(
            f"{path}: is binary, of a format that is not known; export it as C3D, BVH or CSV"
        )
    opened = io.StringIO(head.decode(text.encoding, errors="replace"), newline=None)
    lines = [line.rstrip("\n") for line in itertools.islice(opened, _LINES)]
    if acclaim.is_asf(lines):
        raise MotionFileError(f"{path}: is a skeleton; give the .amc with the motion instead")
    if acclaim.is_amc(lines):
        return acclaim.read_acclaim(text, skeleton, report)
    readers = (read for recognises, read in TEXT_FORMATS.items() if recognises(lines))
    return next(readers, read_table)(text, report)
