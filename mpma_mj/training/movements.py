"""What a run imitates: one movement, or a repertoire of several."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError, MotionFileError, RecordingWarning
from mpma_mj.motions import Motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.reach import check_reach
from mpma_mj.motions.read import BUILT_IN, read_with_findings
from mpma_mj.motions.repertoire import join
from mpma_mj.training.config import RunConfig

__all__ = ["expand_folders", "read_movements"]

# By which files in a folder are taken for recordings; what they are is told by their content.
_ENDINGS = {".amc", ".bvh", ".c3d", ".csv", ".npz", ".trc", ".tsv"}
_OF_ONE_FILE = ("labels", "audio", "start", "end", "skeleton")


def expand_folders(sources: Sequence[str]) -> tuple[str, ...]:
    """Replace each folder by the recordings in it, in the order of their names.

    Raises:
        MotionFileError: A folder holds none.
    """
    expanded: list[str] = []
    for source in sources:
        if not Path(source).is_dir():
            expanded.append(source)
            continue
        found = sorted(str(p) for p in Path(source).iterdir() if p.suffix.lower() in _ENDINGS)
        if not found:
            raise MotionFileError(
                f"{source}: holds no recording; expected files that end in"
                f" {', '.join(sorted(_ENDINGS))}"
            )
        expanded += found
    return tuple(expanded)


def read_movements(config: RunConfig) -> Motion:
    """Read what a run imitates; several movements become a repertoire with a label for each.

    Args:
        config: Names the movements and how to read them.

    Raises:
        MpmaError: A movement cannot be read, or danced; or an option is for one file alone.
    """
    given = [name for name in _OF_ONE_FILE if getattr(config, name) is not None]
    if given and len(config.motions) > 1:
        option = {"start": "from", "end": "to"}.get(given[0], given[0])
        raise BadOptionError(f"{option} is for one recording, and there are {len(config.motions)}")
    motions = []
    for source in config.motions:
        # A recording's options mean nothing to a movement that is built in beside it.
        alone = len(config.motions) == 1 or source not in BUILT_IN
        options = config.reading if alone else ReadingOptions(tempo=config.tempo)
        reading = read_with_findings(source, options)
        for warning in reading.findings.warnings:
            warnings.warn(f"{source}: {warning}", RecordingWarning, stacklevel=2)
        motions.append(reading.motion)
    if len(motions) == 1:
        return motions[0]
    limits = arm_limits(config.arms)
    for motion in motions:
        check_reach(motion, *limits)
    return join(motions, limits[0])
