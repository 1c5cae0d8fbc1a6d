"""The way in: a name or a file becomes a `Motion`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from mpma_mj.errors import BadOptionError, MotionFileError, UnknownMotionError
from mpma_mj.motions import cleaning, qualisys
from mpma_mj.motions.body import check_segments, posture_from_points
from mpma_mj.motions.context import equal_segments
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.ymca import ymca

__all__ = ["BUILT_IN", "read_motion"]

BUILT_IN = {"ymca": ymca}
_TEMPO = (0.01, 100.0)  # beyond, a movement has hardly a sample, or fills the memory


def read_motion(
    source: str | Path,
    *,
    rate: float = 20.0,
    tempo: float = 1.0,
    segments: int = 4,
    max_gap: float = 0.25,
) -> Motion:
    """Read a movement: a built-in one by name, or a recording by its file.

    Args:
        source: "ymca", or the path of a Qualisys TSV export.
        rate: Postures per second that are wanted, Hz.
        tempo: Speed relative to the original; 0.5 takes twice as long.
        segments: Number of equal parts that label a recording, which has no labels.
        max_gap: Longest gap in a marker's trajectory that is bridged, s.

    Returns:
        The movement.

    Raises:
        BadOptionError: An option is outside what it may be.
        UnknownMotionError: No built-in movement and no file of that name.
        MotionFileError: The file cannot be read as the movement of two arms.
    """
    if not (math.isfinite(max_gap) and max_gap >= 0):
        raise BadOptionError(f"max-gap is {max_gap:g}; expected seconds, 0 or more")
    for option, value in {"rate": rate, "tempo": tempo}.items():
        if not (math.isfinite(value) and value > 0):
            raise BadOptionError(f"{option} is {value:g}; expected a number above 0")
    if not _TEMPO[0] <= tempo <= _TEMPO[1]:
        raise BadOptionError(f"tempo is {tempo:g}; expected {_TEMPO[0]:g} to {_TEMPO[1]:g}")
    if segments < 1:
        raise BadOptionError(f"segments is {segments}; expected at least 1")
    if str(source) in BUILT_IN:
        return BUILT_IN[str(source)](rate, tempo)
    path = Path(source)
    recording = _read_recording(path, _read_text(path))
    arms = qualisys.arm_points(path, recording.markers)
    needed = {name: recording.markers[name] for group in arms.values() for name in group}
    whole = cleaning.fill_gaps(needed, recording.rate, max_gap, str(path))
    points = {p: np.mean([whole[name] for name in group], axis=0) for p, group in arms.items()}
    check_segments(points, str(path))
    cutoff = min(cleaning.CUTOFF, 0.4 * rate / tempo)
    posture = posture_from_points(
        {
            name: cleaning.resample(
                cleaning.low_pass(track, recording.rate, cutoff), recording.rate * tempo, rate
            )
            for name, track in points.items()
        }
    )
    if segments > len(posture) > 1:
        raise BadOptionError(
            f"segments is {segments}, but {path} gives {len(posture)} postures; expected fewer"
        )
    context, labels = equal_segments(len(posture), segments)
    return Motion(
        posture, context, labels, rate, path.stem, f"Qualisys recording {path.name}", tempo
    )


def _read_text(path: Path) -> str:
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
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MotionFileError(f"{path}: cannot be read ({error.strerror})") from None
    if not text.strip():
        raise MotionFileError(f"{path}: is empty; export the recording anew")
    return text


def _read_recording(path: Path, text: str) -> qualisys.MarkerRecording:
    if not qualisys.is_qualisys(text):
        raise MotionFileError(
            f"{path}: not a Qualisys TSV export (no line MARKER_NAMES), which is what can be"
            " read so far; export the recording as TSV with its header"
        )
    return qualisys.read_qualisys(path, text)
