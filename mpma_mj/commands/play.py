"""Command `mpma play`, and videos of runs for the commands that train."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import check_new_file
from mpma_mj.commands.run_options import Given, Reading
from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import BadOptionError, RenderingError, UnknownMotionError
from mpma_mj.motions.export import MOTION_FORMATS, export_motion, write_joint_angles
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.utils.input_files import is_web_address
from mpma_mj.utils.text import shell_word

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from mpma_mj.envs.options import EnvironmentOptions
    from mpma_mj.motions import Motion
    from mpma_mj.trace import Trace
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["Play", "missing_opengl", "write_run_video"]

_SIZES = (160, 3840), (240, 2160)  # smallest and largest width and height of a video, pixels


@dataclass(frozen=True)
class Play:
    """Play a trained run, or arms that follow a motion ideally, in a window or as a file.

    Such as mpma play runs/ymca --out dance.mp4 for a video, or --out joints.csv for a robot.
    """

    source: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="RUN|MOTION")]
    """Folder of a run; or "ymca", or a recording: C3D, BVH, AMC, TRC, CSV and others
    (docs/guides/recordings.md)."""
    out: Path | None = None
    """File to write, in place of the window: a video as .mp4 (with its sound, where the motion was
    given some with --audio), .gif or .webp; or what the arms did,
    as .csv with joint angles and the commands of a run, .bvh, .trc or .npz."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WIDTHxHEIGHT")] = None
    """Size of the video, pixels; 640x576 if not given."""
    camera: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None
    """Camera of the video: front, side or three_quarter, or one of the run's own model; front if
    not given."""
    overwrite: bool = False
    """Replace that file if it exists."""
    reading: Reading = ReadingOptions()
    """Options of reading a recording."""
    given: Given = frozenset()

    def run(self) -> Path | None:
        """Play until the window is closed, or write the file and return its path."""
        from mpma_mj.envs.frame_writer import VIDEO_FORMATS

        check_new_file("out", self.out, VIDEO_FORMATS + MOTION_FORMATS, overwrite=self.overwrite)
        is_video = self.out is not None and self.out.suffix in VIDEO_FORMATS
        size = self._checked_size(is_video)
        if is_video:
            require_backend()
        trace, motion, times, options = self._of_run() if self._is_run else self._of_motion()
        if self.out is not None and not is_video:
            if options is None:
                export_motion(self.out, motion)
            else:
                _export_run(self.out, trace, motion, options)
            return self.out
        if self.out is not None:
            from mpma_mj.utils.progress import show_frames
            from mpma_mj.visualization.video import VIDEO_SIZE, write_video

            write_video(
                self.out,
                trace,
                motion,
                options=options,
                camera=self.camera or "front",
                size=size or VIDEO_SIZE,
                sound=self._sound,
                progress=show_frames,
            )
            return self.out
        from mpma_mj.visualization.playback import KEYS, play

        keys = "; ".join(f"{key}: {action}" for key, action in KEYS.items())
        play(
            trace,
            motion,
            times=times,
            options=options,
            instead=f"write a file: mpma play {shell_word(self.source)} --out dance.mp4",
            on_open=lambda: print(keys, flush=True),
        )
        return None

    def _checked_size(self, is_video: bool) -> tuple[int, int] | None:
        """Return width and height of the video, None for the default.

        Raises:
            BadOptionError: They are no two even numbers, or too small or large; or an option of
                videos is given for something else.
        """
        for option in ("size", "camera"):
            if not is_video and getattr(self, option) is not None:
                remedy = "give {out=dance.mp4}, or turn the view in the window with the mouse"
                raise BadOptionError(f"--{option} is for a video file", remedy=remedy)
        if self.size is None:
            return None
        (low_width, high_width), (low_height, high_height) = _SIZES
        found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", self.size)
        if found:
            width, height = int(found[1]), int(found[2])
            within = low_width <= width <= high_width and low_height <= height <= high_height
            if within and width % 2 == height % 2 == 0:
                return width, height
        expected = f"two even numbers from {low_width}x{low_height} to {high_width}x{high_height}"
        raise BadOptionError(option="size", value=self.size, expected=expected)

    @property
    def _is_run(self) -> bool:
        from mpma_mj.motions import BUILT_IN

        return self.source not in BUILT_IN and Path(self.source).is_dir()

    @property
    def _sound(self) -> Path | None:
        """Music of the run, or that was given with the motion."""
        from mpma_mj.training.run_folder import RunFolder

        if self._is_run:
            return RunFolder(Path(self.source)).sound
        return None if self.reading.audio is None else Path(self.reading.audio)

    def _of_run(self) -> tuple[Trace, Motion, None, EnvironmentOptions]:
        from mpma_mj.training.run_folder import RunFolder

        folder = RunFolder(Path(self.source))
        options = folder.read_config().env
        for option in sorted(self.given & {field.name for field in fields(ReadingOptions)}):
            raise BadOptionError(
                f"{self.source} is a run", remedy=f"leave {{{option}}} out: it is for a recording"
            )
        return folder.read_trace(), folder.read_motion(), None, options

    def _of_motion(self) -> tuple[Trace, Motion, NDArray[np.float64], None]:
        from mpma_mj.envs.load import arm_limits
        from mpma_mj.motions import BUILT_IN
        from mpma_mj.motions.loader import import_motion
        from mpma_mj.visualization.episode import ideal_trace

        known = self.source in BUILT_IN or Path(self.source).exists()
        if not (known or is_web_address(self.source)):
            raise UnknownMotionError(
                f"no run or motion '{self.source}'; expected the folder of a run, ymca, or the path"
                " of a recording"
            )
        motion, report = import_motion(self.source, self.reading, limits=arm_limits("physics"))
        report.emit_warnings(self.source)
        return ideal_trace(motion), motion, report.times, None


def _export_run(path: Path, trace: Trace, motion: Motion, options: EnvironmentOptions) -> None:
    """Write what the arms of a run did: for each step the posture in which it began.

    A `.csv` has the joint angles that the arms had, less whole turns where a joint has no range,
    and the joint velocities commanded in the step.
    """
    from mpma_mj.envs.load import arm_limits
    from mpma_mj.joint_paths import unwound

    if path.suffix == ".csv":
        limits, angles = arm_limits(options), trace.true_joint_angles()[:-1]
        free = limits.highest - limits.lowest == math.inf
        angles[:, free] = unwound(angles[:, free])
        write_joint_angles(path, angles, motion.rate, trace.action * limits.max_speed)
        return
    source = f"arms that imitate {motion.source}"
    posture, context = trace.posture[:-1], trace.context[:-1]
    done = replace(motion, posture=posture, context=context, source=source, feasible_angles=None)
    export_motion(path, done)


def missing_opengl() -> str | None:
    """Look for OpenGL before a long computation; return the message to print after it, if any."""
    try:
        require_backend()
    except RenderingError as error:
        return f"mpma: {error}"
    return None


def write_run_video(folder: RunFolder) -> None:
    """Write the video of a run to its folder.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
        MpmaError: The run is damaged.
    """
    from mpma_mj.utils.progress import show_frames
    from mpma_mj.visualization.video import write_video

    trace, motion, options = folder.read_trace(), folder.read_motion(), folder.read_config().env
    write_video(
        folder.video, trace, motion, options=options, sound=folder.sound, progress=show_frames
    )
