"""Data set of a run: one motion, or a repertoire of several."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError, MotionFileError, RecordingWarning
from mpma_mj.motions import Motion
from mpma_mj.motions.built_in import built_in
from mpma_mj.motions.context import read_labels
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.loader import import_motion, refuse_run
from mpma_mj.motions.options import ReadingOptions, given
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.transforms import join
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.input_files import file_problem

__all__ = ["expand_folders", "read_motions"]

# Endings of files in a folder that count as recordings, JSON if it has points of a body; their
# format is recognised by content.
_ENDINGS = {".amc", ".bvh", ".c3d", ".csv", ".json", ".mvnx", ".npy", ".npz", ".trc", ".tsv"}
# Options of reading that refer to one file.
_SINGLE_FILE_OPTIONS = {
    *("start", "end", "skeleton", "loop", "context", "segments", "labels", "audio"),
}


def expand_folders(sources: Sequence[str]) -> tuple[str, ...]:
    """Replace each folder by the recordings in it, sorted by name.

    Args:
        sources: Names of built-in motions, and paths of recordings and folders.

    Raises:
        BadOptionError: A built-in motion cannot spell its word.
        MotionFileError: A folder contains no recording, or is that of a run.
    """
    expanded: list[str] = []
    for source in sources:
        if built_in(source) or not Path(source).is_dir():
            expanded.append(source)
            continue
        refuse_run(Path(source))
        files = sorted(p for p in Path(source).iterdir() if p.suffix.lower() in _ENDINGS)
        recordings = [str(path) for path in files if not path.is_dir() and _is_recording(path)]
        if not recordings:
            raise MotionFileError(
                f"{source}: contains no recording; expected files that end in"
                f" {', '.join(sorted(_ENDINGS))}"
            )
        expanded += recordings
    return tuple(expanded)


def _is_recording(path: Path) -> bool:
    """Return whether a file is a recording, rather than labels of one or JSON of something else.

    A `RecordingWarning` names such JSON, as it may also be a damaged recording.
    """
    ending = path.suffix.lower()
    try:
        if ending == ".csv":
            return not read_labels(path)
        if ending == ".json" and not file_problem(path):
            open_recording(path, ImportReport())
    except MotionFileError as error:
        if ending == ".json":
            warnings.warn(RecordingWarning(f"left out: {error}"), stacklevel=3)
        return ending == ".csv"
    return True


def read_motions(config: RunConfig) -> Motion:
    """Read the motion of a run, feasible for its arms; several become a repertoire.

    Raises:
        MpmaError: A recording cannot be read, or an option of a single recording is given with
            several motions.
    """
    single = len(config.motions) == 1
    single_file_options = given(config.reading) & _SINGLE_FILE_OPTIONS
    if single_file_options and not single:
        problem = f"is for one recording, but there are {len(config.motions)}; leave it out"
        raise BadOptionError(problem, option=min(single_file_options))
    limits = arm_limits(config.env)
    timestep = config.env.control_timestep
    rate = {} if timestep is None else {"rate": 1.0 / timestep}
    motions = []
    for source in config.motions:
        # In a repertoire the options of recordings do not apply to built-in motions.
        all_options = single or not built_in(source)
        options = config.reading if all_options else ReadingOptions(tempo=config.reading.tempo)
        motion, report = import_motion(source, options, limits=limits, **rate)
        report.emit_warnings(source)
        motions.append(motion)
    if len(motions) == 1:
        return motions[0]
    return join(motions, limits.max_speed, limits.kinematics)
