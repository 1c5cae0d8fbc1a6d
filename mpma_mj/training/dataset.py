"""What a run imitates: one movement, or a repertoire of several."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.motions import Motion
from mpma_mj.motions.label_file import read_labels
from mpma_mj.motions.options import ReadingOptions, given
from mpma_mj.motions.reach import check_reach
from mpma_mj.motions.read import BUILT_IN, read_with_findings
from mpma_mj.motions.repertoire import join
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.option_names import option_name

__all__ = ["expand_folders", "read_motions"]

# By which files in a folder are taken for recordings; what they are is told by their content.
_ENDINGS = {".amc", ".bvh", ".c3d", ".csv", ".npz", ".trc", ".tsv"}
_OF_ONE_FILE = {
    *("start", "end", "skeleton", "loop", "context", "segments", "labels", "audio"),
}


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
        files = sorted(p for p in Path(source).iterdir() if p.suffix.lower() in _ENDINGS)
        found = [str(path) for path in files if not _is_labels(path)]
        if not found:
            raise MotionFileError(
                f"{source}: holds no recording; expected files that end in"
                f" {', '.join(sorted(_ENDINGS))}"
            )
        expanded += found
    return tuple(expanded)


def _is_labels(path: Path) -> bool:
    """Tell whether a file is labels that belong to a recording, rather than a recording."""
    if path.suffix.lower() != ".csv":
        return False
    try:
        return bool(read_labels(path))
    except MotionFileError:
        return False


def read_motions(config: RunConfig) -> Motion:
    """Read what a run imitates; several movements become a repertoire with a label for each.

    Args:
        config: Names the movements and how to read them.

    Raises:
        MpmaError: A movement cannot be read, or danced; or an option is for one file alone.
    """
    alone = len(config.motions) == 1
    useless = given(config.reading) & _OF_ONE_FILE
    if useless and not alone:
        raise BadOptionError(
            f"{option_name(min(useless))} is for one recording, and there are"
            f" {len(config.motions)}; leave it out"
        )
    motions = []
    for source in config.motions:
        # A recording's options mean nothing to a movement that is built in beside it.
        takes_all = alone or source not in BUILT_IN
        options = config.reading if takes_all else ReadingOptions(tempo=config.reading.tempo)
        reading = read_with_findings(source, options)
        reading.findings.tell(source)
        motions.append(reading.motion)
    if len(motions) == 1:
        return motions[0]
    limits = arm_limits(config.env.arms)
    for motion in motions:
        check_reach(motion, *limits)
    return join(motions, limits[0])
