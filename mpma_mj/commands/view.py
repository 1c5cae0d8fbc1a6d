"""Command `mpma view`."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.run_options import Reading
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.options import ReadingOptions, given
from mpma_mj.utils.text import option_name

if TYPE_CHECKING:
    from mpma_mj.visualization.playback import Dance

__all__ = ["View"]


@dataclass(frozen=True)
class View:
    """Play a trained run, or arms that follow a recording ideally, in a window."""

    dance: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="RUN|MOTION")]
    """Folder of a run; or "ymca", or a recording: C3D, BVH, AMC, TRC, TSV, CSV, npz."""
    reading: Reading = ReadingOptions()
    """Options of reading a recording."""

    def run(self) -> None:
        """Play until the window is closed."""
        from mpma_mj.motions.synthetic import BUILT_IN

        is_run = self.dance not in BUILT_IN and Path(self.dance).is_dir()
        dance = self._of_run() if is_run else self._of_recording()
        word = shlex.quote(self.dance)
        video = f"mpma render {word}" if is_run else f"mpma motion {word} --video"

        from mpma_mj.visualization.playback import play

        play(dance, instead=f"make a video: {video}", on_open=_print_keys)

    def _of_run(self) -> Dance:
        from mpma_mj.training.run_folder import RunFolder
        from mpma_mj.visualization.playback import Dance

        folder = RunFolder(Path(self.dance))
        options = folder.read_config().env
        reading_options = given(self.reading)
        if reading_options:
            raise BadOptionError(
                f"{option_name(min(reading_options))} is for a recording, and {self.dance} is a"
                " run; leave it out"
            )
        return Dance.of_run(folder.read_trace(), folder.read_motion(), options)

    def _of_recording(self) -> Dance:
        from mpma_mj.motions.loader import import_motion
        from mpma_mj.visualization.playback import Dance

        motion, report = import_motion(self.dance, self.reading)
        report.emit_warnings(self.dance)
        return Dance.of_motion(motion, report.times)


def _print_keys() -> None:
    from mpma_mj.visualization.playback import KEYS

    print("; ".join(f"{key}: {action}" for key, action in KEYS.items()), flush=True)
