"""Command `mpma motion`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from mpma_mj.commands.folders import check_new_file
from mpma_mj.commands.run_options import MotionName, Reading
from mpma_mj.envs.gl import require_backend
from mpma_mj.motions.export import MOTION_FORMATS, export_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.options import TWO_ARM

if TYPE_CHECKING:
    from mpma_mj.motions import Motion

__all__ = ["InspectMotion"]


@dataclass(frozen=True)
class InspectMotion:
    """Inspect or convert a motion: its report as text and figures, the motion itself as a file.

    Such as mpma motion dance.c3d --out dance.bvh for animators, or --robot h1 --out angles.csv for
    a robot, with what it can reach and at which tempo it can do all.
    """

    motion: MotionName
    picture: Path | None = None
    """File of the page of figures, .png; NAME-motion.png if not given."""
    video: bool = False
    """Write a video of arms that follow the motion ideally, next to the page, as .mp4."""
    out: Path | None = None
    """Write the motion: joint angles as .csv, a skeleton as .bvh, points as .trc, or .npz, which
    also has the context. All commands can read each of them, but a .csv of --robot."""
    overwrite: bool = False
    """Replace the files of --out and --picture if they exist."""
    robot: str = TWO_ARM
    """Robot for which the motion is inspected and written, by its name or the path of its file."""
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
        from mpma_mj.envs.options import EnvironmentOptions
        from mpma_mj.motions.feasibility import demand_lines
        from mpma_mj.motions.loader import import_motion
        from mpma_mj.motions.reach import reach_lines, reach_of
        from mpma_mj.utils.progress import show_frames
        from mpma_mj.utils.text import printable
        from mpma_mj.visualization.motion_page import write_page
        from mpma_mj.visualization.scene import ideal_scene
        from mpma_mj.visualization.video import write_video

        arms = EnvironmentOptions(arms="kinematic", robot=self.robot)
        limits = arm_limits(arms)
        motion, report = import_motion(self.motion, self.reading, limits=limits)
        report.emit_warnings(self.motion)
        if self.out is not None:
            export_motion(self.out, motion, limits)
        picture = self.picture or Path(f"{motion.name}-motion.png")
        write_page(picture, motion, report, limits)
        lines = [*report.lines(motion), *demand_lines(motion, limits)]
        if self.robot != TWO_ARM:
            slower = None if self.reading.tempo == "auto" else self._at_tempo
            lines += reach_lines(reach_of(motion, limits), slower, limits)
        print("\n".join(lines))
        if self.video:
            video = picture.with_suffix(".mp4")
            audio = self.reading.audio
            scene = ideal_scene(motion, audio, options=arms, kinematics=limits.kinematics)
            write_video(video, scene, show_frames)
            print(printable(str(video)))
        if self.out is None:
            return picture
        print(printable(str(picture)))
        return self.out

    def _at_tempo(self, tempo: float) -> Motion:
        """Return the motion at a tempo, relative to that of the options."""
        from mpma_mj.motions.loader import import_motion

        tempo *= self.reading.own_tempo
        return import_motion(self.motion, replace(self.reading, tempo=tempo, strict=False)).motion
