"""Videos of episodes."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Generator, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.frame_writer import frame_writer
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.visualization.episode import EpisodeArms
from mpma_mj.visualization.responsibility_strip import STRIP_HEIGHT, Strip

__all__ = ["VIDEO_SIZE", "Progress", "episode_frames", "write_frames", "write_video"]

Picture = NDArray[np.uint8]
Progress = Callable[[range], Iterable[int]]

VIDEO_SIZE = 640, 480 + STRIP_HEIGHT
"""Width and height of videos, pixels."""


def write_video(
    path: Path,
    trace: Trace,
    motion: Motion,
    *,
    options: EnvironmentOptions | None = None,
    camera: str = "front",
    size: tuple[int, int] = VIDEO_SIZE,
    sound: Path | None = None,
    progress: Progress = iter,
) -> None:
    """Write the video of an episode: arms, ghost of the demonstration, labels, responsibilities.

    Frames are encoded one by one, and the video plays in real time.

    Args:
        path: The `.mp4`, `.gif` or `.webp` file.
        trace: Trace of the episode.
        motion: The motion that was imitated.
        options: Options of the environment, whose arms are drawn; the defaults if not given.
        camera: Camera of the model.
        size: Width and height of the video, pixels; even for an `.mp4`.
        sound: Sound file of the music to which the motion belongs, for an `.mp4`.
        progress: Wraps the range of frames to show progress.

    Raises:
        BadOptionError: The environment's model cannot be read, or has no such camera.
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
    """
    arms_size = size[0], size[1] - STRIP_HEIGHT
    frames = episode_frames(
        trace, motion, options=options, camera=camera, size=arms_size, progress=progress
    )
    repeats = 1 if options is None else options.repeats
    soundtrack = None if sound is None else Soundtrack.of(sound, motion, len(trace), repeats)
    write_frames(path, frames, motion.rate, soundtrack)


def write_frames(
    path: Path, frames: Iterable[Picture], rate: float, sound: Soundtrack | None = None
) -> None:
    """Write pictures as a video.

    Args:
        path: The `.mp4`, `.gif` or `.webp` file.
        frames: Pictures of one size, shape (H, W, 3) each, taken one by one; even H and W for an
            `.mp4`.
        rate: Pictures per second, Hz.
        sound: Sound of an `.mp4`.

    Raises:
        VideoError: The encoder is missing, or fails.
    """
    frames = iter(frames)
    first = next(frames)
    with frame_writer(path, first.shape[:2], rate, sound) as write:
        for frame in itertools.chain([first], frames):
            write(frame)


def episode_frames(
    trace: Trace,
    motion: Motion,
    *,
    options: EnvironmentOptions | None = None,
    camera: str = "front",
    size: tuple[int, int] = (640, 480),
    progress: Progress = iter,
) -> Generator[Picture, None, None]:
    """Draw an episode frame by frame, a frame for each control step.

    As `write_video`, but for the size: width and height of the picture of the arms, pixels.

    Yields:
        Pictures, shape (height + STRIP_HEIGHT, width, 3).
    """
    width, height = size
    strip = _strip(trace, motion, width)
    arms = EpisodeArms(trace, options)
    renderer = ArmRenderer(arms.physics, width=width, height=height, camera=camera)
    with contextlib.closing(renderer):
        for step in progress(range(len(trace))):
            arms.pose(step)
            yield strip.under(renderer.picture(ghost=trace.reference[step]), step)


def _strip(trace: Trace, motion: Motion, width: int) -> Strip:
    """Return the strip below the picture: responsibilities, or labels without modules."""
    context = trace.context[:-1]
    if trace.modules is not None:
        return Strip(trace.modules.responsibility, context, motion.labels, width=width)
    shares = context / np.maximum(context.sum(axis=1, keepdims=True), 1.0)
    return Strip(shares, context, motion.labels, bands=motion.labels, width=width)
