"""Videos of episodes."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Generator, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.cameras import check_camera, orbit_camera
from mpma_mj.envs.frame_writer import frame_writer
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.visualization.episode import EpisodeArms
from mpma_mj.visualization.responsibility_strip import STRIP_HEIGHT, Strip
from mpma_mj.visualization.scene import ORBIT, Scene

__all__ = ["Progress", "episode_frames", "write_frames", "write_video"]

Picture = NDArray[np.uint8]
Progress = Callable[[range], Iterable[int]]

_WIDTH, _HEIGHT = 640, 480  # of the picture of the arms, pixels


def write_video(path: Path, scene: Scene, progress: Progress = iter) -> None:
    """Write the video of a scene: arms, ghost of the demonstration, labels, responsibilities.

    Frames are encoded one by one, and the video plays in real time.

    Args:
        path: The file, whose ending is one of `frame_writer.VIDEO_FORMATS`.
        scene: What is shown.
        progress: Wraps the range of frames to show progress.

    Raises:
        BadOptionError: The environment's model cannot be read, or has no such camera.
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
    """
    write_frames(path, episode_frames(scene, progress), scene.rate, scene.sound)


def write_frames(
    path: Path, frames: Iterable[Picture], rate: float, sound: Soundtrack | None = None
) -> None:
    """Write frames as a video.

    Args:
        path: The file, whose ending is one of `frame_writer.VIDEO_FORMATS`.
        frames: Frames of one size, shape (H, W, 3) each, taken one by one; even H and W for the
            formats of `frame_writer.EVEN_SIZED`.
        rate: Frames per second, Hz.
        sound: Sound, for the formats of `frame_writer.SOUND_CODECS`.

    Raises:
        VideoError: The encoder is missing, or fails.
    """
    frames = iter(frames)
    first = next(frames)
    with frame_writer(path, first.shape[:2], rate, sound) as write:
        for frame in itertools.chain([first], frames):
            write(frame)


def episode_frames(scene: Scene, progress: Progress = iter) -> Generator[Picture, None, None]:
    """Draw a scene frame by frame; see `write_video`.

    Yields:
        Frames, shape (height, width, 3) each.
    """
    strip_height = STRIP_HEIGHT if scene.captions else 0
    width, height = scene.size or (_WIDTH, _HEIGHT + strip_height)
    height -= strip_height
    strip = _strip(scene, width) if scene.captions else None
    arms, moments = EpisodeArms(scene.trace, scene.options, scene.motion.angles_of), scene.moments
    orbit = orbit_camera(arms.physics, width / height)
    begin = orbit.azimuth
    if scene.camera != ORBIT:
        check_camera(arms.physics, scene.camera, ORBIT)
    camera = orbit if scene.camera == ORBIT else scene.camera
    renderer = ArmRenderer(arms.physics, width=width, height=height, camera=camera)
    with contextlib.closing(renderer):
        for frame in progress(range(len(moments))):
            orbit.azimuth = begin + 360.0 * frame / len(moments)
            picture = renderer.picture(ghost=arms.pose(moments[frame]))
            yield strip.under(picture, int(moments[frame])) if strip else picture


def _strip(scene: Scene, width: int) -> Strip:
    shares, bands = scene.shares
    return Strip(shares, scene.trace.context[:-1], scene.motion.labels, bands, width=width)
