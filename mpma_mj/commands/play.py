"""Command `mpma play`."""

from __future__ import annotations

import functools
import math
import re
import warnings
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from mpma_mj.commands.folders import check_new_file
from mpma_mj.commands.run_options import Given, Reading, Source
from mpma_mj.commands.run_video import run_scene
from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import BadOptionError, OptionWarning
from mpma_mj.motions.export import MOTION_FORMATS, export_motion, write_joint_angles
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.options import TWO_ARM
from mpma_mj.utils.input_files import is_web_address
from mpma_mj.utils.text import shell_word
from mpma_mj.utils.validation import Bounds, check_fields

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from mpma_mj.envs.options import EnvironmentOptions
    from mpma_mj.motions import Motion
    from mpma_mj.motions.feasibility import JointLimits
    from mpma_mj.training.run_folder import RunFolder
    from mpma_mj.visualization.scene import Scene

__all__ = ["Play"]

_SIZES = (160, 3840), (240, 2160)  # smallest and largest width and height of a video, pixels
_PAGE = ".html"
_LOOKS = ("size", "fps", "camera", "captions")  # options of how a video is shown
_LOOKS_OF = {_PAGE: ("fps", "camera", "captions"), "": ("camera", "captions")}  # "": the window
_GIF_FPS = 50.0  # Hz: browsers slow down what is faster


@dataclass(frozen=True)
class Play:
    """Play a trained run, or arms that follow a motion ideally, in a window or as a file.

    Such as mpma play runs/ymca --out dance.mp4 for a video, or mpma play ymca --robot h1 --out
    joints.csv for a robot, which then does the closest that its joints can. With
    --browser the agent dances live in a page, where it can be pushed and loaded, and its modules
    switched off; the feedback controller follows a motion there.
    """

    source: Source
    out: Path | None = None
    """File to write, in place of the window: a video as .mp4 or .webm (with its sound, where the
    motion was given some with --audio), .gif or .webp; a page for a browser as .html, in which the
    mouse turns the view; or what the arms did, as .csv with joint angles and the commands of a run,
    .bvh, .trc or .npz."""
    size: Annotated[str | None, tyro.conf.arg(metavar="WIDTHxHEIGHT")] = None
    """Size of the video, pixels; 640x576 if not given, or 640x480 without captions."""
    fps: Annotated[float, Bounds(0.1, 1000.0, hint="Hz")] | None = None
    """Frames per second of the video or the page; one for each control step if not given."""
    camera: Annotated[str, tyro.conf.arg(metavar="NAME")] = "front"
    """Camera: front, side or three_quarter, or one of the run's own model; or orbit, which goes
    around once in the length of a video."""
    captions: bool = True
    """Show labels and responsibilities."""
    overwrite: bool = False
    """Replace that file if it exists."""
    browser: bool = False
    """Show a page for a web browser in place of the window (docs/guides/browser.md)."""
    host: str | None = None
    """Address at which the page is served; 127.0.0.1 if not given, which no other machine reaches,
    or 0.0.0.0 to let all of them watch and control it."""
    port: int | None = None
    """Port of the page, or the next one that is free; 8080 if not given."""
    robot: str = TWO_ARM
    """Robot that shows a motion, by its name or the path of its file; a run has its own."""
    reading: Reading = ReadingOptions()
    """Options of reading a recording."""
    given: Given = frozenset()

    def run(self) -> Path | None:
        """Play until the window is closed, or write the file and return its path."""
        from mpma_mj.envs.frame_writer import VIDEO_FORMATS

        self._check_page()
        formats = (*VIDEO_FORMATS, _PAGE, *MOTION_FORMATS)
        check_new_file("out", self.out, formats, overwrite=self.overwrite)
        ending = "" if self.out is None else self.out.suffix
        size = self._checked_size()
        self._check_looks(ending, is_video=ending in VIDEO_FORMATS)
        if self.browser:
            self._serve_page()
            return None
        if ending in VIDEO_FORMATS:
            require_backend()
        elif ending == _PAGE:
            from mpma_mj.visualization.viser_arms import require_web

            require_web()
        scene = self._of_run() if self._is_run else self._of_motion()
        scene = replace(scene, camera=self.camera, captions=self.captions, size=size, fps=self.fps)
        if self.out is None:
            self._show(scene)
        elif ending not in MOTION_FORMATS:
            self._draw(self.out, scene)
        elif self._is_run:
            _export_run(self.out, scene)
        else:
            export_motion(self.out, scene.motion, self._limits)
        return self.out

    def _show(self, scene: Scene) -> None:
        """Play a scene in the window until it is closed."""
        from mpma_mj.visualization.playback import KEYS, play

        keys = "; ".join(f"{key}: {action}" for key, action in KEYS.items())
        instead = f"write a file: mpma play {shell_word(self.source)} --out dance.mp4"
        play(scene, instead=instead, on_open=lambda: print(keys, flush=True))

    def _draw(self, path: Path, scene: Scene) -> None:
        """Write a scene as a video or a page."""
        from mpma_mj.envs.frame_writer import SOUND_CODECS
        from mpma_mj.utils.progress import show_frames

        if "audio" in self.given and path.suffix not in SOUND_CODECS:
            remedy = f"write {' or '.join(SOUND_CODECS)} for the sound"
            warnings.warn(OptionWarning(f"{path} has no sound", remedy=remedy), stacklevel=2)
        if path.suffix == _PAGE:
            from mpma_mj.visualization.html_file import write_html

            write_html(path, scene, show_frames)
        else:
            from mpma_mj.visualization.video import write_video

            write_video(path, scene, show_frames)

    def _check_page(self) -> None:
        """Refuse options of the page without one, and files with one.

        Raises:
            BadOptionError: There is such an option.
        """
        for option in ("host", "port"):
            if not self.browser and getattr(self, option) is not None:
                remedy = "give {browser}, or leave it out"
                raise BadOptionError("is for the page", option=option, remedy=remedy)
        if self.browser and self.out is not None:
            raise BadOptionError("writes no file", option="browser", remedy="leave {out} out")

    def _serve_page(self) -> None:
        """Serve the page until the process is interrupted."""
        from mpma_mj.browser.server import PORT, THIS_MACHINE, find_address
        from mpma_mj.visualization.viser_arms import require_web

        require_web()
        address = find_address(self.host or THIS_MACHINE, PORT if self.port is None else self.port)
        from mpma_mj.browser.episode_factory import EpisodeFactory
        from mpma_mj.browser.page import serve
        from mpma_mj.browser.simulation import LiveSimulation

        if self._is_run:
            factory = EpisodeFactory.of_run(self._folder())
        else:
            motion = self._read_motion()[0]
            factory = EpisodeFactory.of_motion(motion, self._arms)
        serve(address, LiveSimulation(factory), on_open=lambda url: print(url, flush=True))

    def _check_looks(self, ending: str, *, is_video: bool) -> None:
        """Check the options of how the scene is shown.

        Raises:
            BadOptionError: One is out of bounds, or is given for something else.
        """
        check_fields(self)
        useful = _LOOKS if is_video else () if self.browser else _LOOKS_OF.get(ending, ())
        for option in _LOOKS:
            if option in self.given and option not in useful:
                if self.browser:
                    remedy = "leave it out, as the page has its own"
                    raise BadOptionError("is not for the page", option=option, remedy=remedy)
                remedy = "give {out=dance.mp4}"
                raise BadOptionError("is for a video file", option=option, remedy=remedy)
        if self.camera == "orbit" and not is_video:
            remedy = "give {out=dance.mp4}, or turn the view with the mouse"
            raise BadOptionError("orbit is for a video file", option="camera", remedy=remedy)
        if ending == ".gif" and self.fps is not None and self.fps > _GIF_FPS:
            expected = f"at most {_GIF_FPS:g} Hz for a .gif, which browsers slow down otherwise"
            raise BadOptionError(option="fps", value=self.fps, expected=expected)

    def _checked_size(self) -> tuple[int, int] | None:
        """Return width and height of the video, None for the default.

        Raises:
            BadOptionError: They are no two numbers, or too small or large, or odd where the format
                has even ones only.
        """
        from mpma_mj.envs.frame_writer import EVEN_SIZED

        if self.size is None or self.out is None:
            return None
        (low_width, high_width), (low_height, high_height) = _SIZES
        even = self.out.suffix in EVEN_SIZED
        found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", self.size)
        if found:
            width, height = int(found[1]), int(found[2])
            within = low_width <= width <= high_width and low_height <= height <= high_height
            if within and not (even and (width % 2 or height % 2)):
                return width, height
        kind = "even" if even else "whole"
        expected = f"two {kind} numbers from {low_width}x{low_height} to {high_width}x{high_height}"
        raise BadOptionError(option="size", value=self.size, expected=expected)

    @property
    def _is_run(self) -> bool:
        from mpma_mj.motions.built_in import built_in

        return not built_in(self.source) and Path(self.source).is_dir()

    def _of_run(self) -> Scene:
        scene = run_scene(self._folder("start", "end"))
        if not self.given & {"start", "end"}:
            return scene
        end = math.inf if self.reading.end is None else self.reading.end
        return scene.cut(self.reading.start or 0.0, end)

    def _folder(self, *useful: str) -> RunFolder:
        """Return the folder of the run; options of reading are refused, but for useful ones."""
        from mpma_mj.training.run_folder import RunFolder

        of_recordings = {field.name for field in fields(ReadingOptions)}.difference(useful)
        for option in sorted(self.given & of_recordings):
            cut = option in ("start", "end")
            why = "the page plays it as a whole" if cut else "it is for a recording"
            raise BadOptionError(f"{self.source} is a run", remedy=f"leave {{{option}}} out: {why}")
        if "robot" in self.given:
            remedy = "leave {robot} out: it has its own"
            raise BadOptionError(f"{self.source} is a run", remedy=remedy)
        self.reading.check()
        return RunFolder(Path(self.source))

    def _of_motion(self) -> Scene:
        from mpma_mj.visualization.scene import ideal_scene

        motion, times = self._read_motion()
        return ideal_scene(motion, self.reading.audio, times, self._arms, self._limits.kinematics)

    @functools.cached_property
    def _arms(self) -> EnvironmentOptions:
        """Arms that follow a motion: ideal ones; for the page simulated ones, if they are known."""
        from mpma_mj.envs.options import EnvironmentOptions
        from mpma_mj.robots.robot_file import read_robot

        simulated = self.browser and not read_robot(self.robot).unknown
        return EnvironmentOptions(arms="physics" if simulated else "kinematic", robot=self.robot)

    @functools.cached_property
    def _limits(self) -> JointLimits:
        from mpma_mj.envs.load import arm_limits

        return arm_limits(self._arms)

    def _read_motion(self) -> tuple[Motion, NDArray[np.float64]]:
        """Return the motion and its times in the recording."""
        from mpma_mj.motions.built_in import built_in, unknown_motion
        from mpma_mj.motions.loader import import_motion

        known = built_in(self.source) or Path(self.source).exists()
        if not (known or is_web_address(self.source)):
            raise unknown_motion(self.source, "run or motion", "the folder of a run, ")
        motion, report = import_motion(self.source, self.reading, limits=self._limits)
        report.emit_warnings(self.source)
        return motion, report.times


def _export_run(path: Path, scene: Scene) -> None:
    """Write what the arms of a run did: for each step the posture in which it began.

    A `.csv` has the joint angles that the arms had, less whole turns where a joint has no range,
    and the joint velocities commanded in the step.
    """
    from mpma_mj.envs.load import arm_limits, check_same_robot

    trace, motion = scene.trace, scene.motion
    if path.suffix == ".csv":
        limits = arm_limits(scene.options or "physics")
        check_same_robot(motion.angles_of, limits.kinematics.name, of_run=True)
        angles = trace.true_joint_angles(limits.kinematics)[:-1]
        write_joint_angles(path, angles, motion.rate, trace.action * limits.max_speed, limits)
        return
    source = f"arms that imitate {motion.source}"
    posture, context = trace.posture[:-1], trace.context[:-1]
    still = replace(motion, feasible_angles=None, angles_of=TWO_ARM)
    export_motion(path, replace(still, posture=posture, context=context, source=source))
