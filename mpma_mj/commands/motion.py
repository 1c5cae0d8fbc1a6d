"""Command `mpma motion`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mpma_mj.commands.folders import check_new_file
from mpma_mj.commands.run_options import Reading
from mpma_mj.envs.gl import require_backend
from mpma_mj.motions.export import MOTION_FORMATS, export_motion
from mpma_mj.motions.options import ReadingOptions

__all__ = ["InspectMotion"]


@dataclass(frozen=True)
class InspectMotion:
    """Inspect or convert a motion: its report as text and figures, the motion itself as a file.

    Such as mpma motion dance.c3d --out dance.bvh for animators, or --out angles.csv for a robot.
    """

    motion: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")]
    """"ymca", or a recording: C3D, BVH, AMC, TRC, CSV and others (docs/guides/recordings.md),
    or a video (docs/guides/video.md, experimental)."""
    picture: Path | None = None
    """File of the page of figures, .png; NAME-motion.png if not given."""
    video: bool = False
    """Write a video of arms that follow the motion ideally, next to the page, as .mp4."""
    out: Path | None = None
    """Write the motion: joint angles as .csv, a skeleton as .bvh, points as .trc, or .npz, which
    also has the context. All commands can read each of them."""
    overwrite: bool = False
    """Replace the files of --out and --picture if they exist."""
    reading: Reading = ReadingOptions()
    """Options of reading the recording."""

    def run(self) -> Path:
        """Inspect the motion and return the path of the file that is asked for, or the page."""
        if self.video:
            require_backend()
        check_new_file("out", self.out, MOTION_FORMATS, overwrite=self.overwrite)
        check_new_file("picture", self.picture, (".png",), overwrite=self.overwrite)
        if self.video and self.picture is not None:
            video = self.picture.with_suffix(".mp4")
            check_new_file("picture", video, (".mp4",), overwrite=self.overwrite)
        from mpma_mj.envs.load import arm_limits
        from mpma_mj.motions.feasibility import demand_lines
        from mpma_mj.motions.loader import import_motion
        from mpma_mj.utils.progress import show_frames
        from mpma_mj.utils.text import printable
        from mpma_mj.visualization.episode import ideal_trace
        from mpma_mj.visualization.motion_page import write_page
        from mpma_mj.visualization.video import write_video

        limits = arm_limits("physics")
        motion, report = import_motion(self.motion, self.reading, limits=limits)
        report.emit_warnings(self.motion)
        if self.out is not None:
            export_motion(self.out, motion)
        picture = self.picture or Path(f"{motion.name}-motion.png")
        write_page(picture, motion, report, limits.max_speed)
        print("\n".join([*report.lines(motion), *demand_lines(motion, limits)]))
        if self.video:
            video = picture.with_suffix(".mp4")
            sound = None if self.reading.audio is None else Path(self.reading.audio)
            write_video(video, ideal_trace(motion), motion, sound=sound, progress=show_frames)
            print(printable(str(video)))
        if self.out is None:
            return picture
        print(printable(str(picture)))
        return self.out
