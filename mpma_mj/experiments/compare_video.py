"""Videos and pictures of comparisons: arms next to each other, and heavy arms over ideal ones."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mpma_mj.envs.soundtrack import Soundtrack
from mpma_mj.experiments.compare import Episode
from mpma_mj.experiments.compare_report import SHOWN
from mpma_mj.motions import Motion
from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.visualization.colours import INK, PAPER
from mpma_mj.visualization.responsibility_strip import STRIP_HEIGHT, label_runs
from mpma_mj.visualization.scene import Scene
from mpma_mj.visualization.video import Progress, episode_frames, write_frames, write_video

__all__ = ["overlaid", "write_overlaid", "write_postures", "write_side_by_side"]

Picture = NDArray[np.uint8]

# Pixels. With gap, title and strip it is 480 x 480, which encoders take.
_WIDTH, _HEIGHT, _GAP, _TITLE = 472, 360, 8, 24
_PICTURES = 4  # largest number of labels in the picture


def write_side_by_side(
    path: Path,
    episodes: Mapping[str, Episode],
    motion: Motion,
    progress: Progress,
    sound: Path | None = None,
) -> None:
    """Write a video of episodes side by side, each with ghost, labels and responsibilities.

    Args:
        path: The `.mp4` file.
        episodes: Episodes of the same length by their titles.
        motion: The motion.
        progress: Wraps the range of frames, to show the progress.
        sound: Sound file of the music to which the motion belongs.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
    """
    titles = np.concatenate([_title(name) for name in episodes], axis=1)
    steps = range(min(len(episode.trace.action) for episode in episodes.values()))
    with contextlib.ExitStack() as stack:
        size = _WIDTH, _HEIGHT + STRIP_HEIGHT
        videos = [
            stack.enter_context(
                contextlib.closing(
                    episode_frames(Scene(episode.trace, motion, episode.options, size=size))
                )
            )
            for episode in episodes.values()
        ]
        frames = (
            np.concatenate([titles, np.concatenate([_apart(next(one)) for one in videos], axis=1)])
            for _ in progress(steps)
        )
        repeats = next(iter(episodes.values())).options.repeats
        soundtrack = Soundtrack.of(sound, motion, len(steps), repeats)
        write_frames(path, frames, motion.rate, soundtrack)


def overlaid(episodes: Mapping[str, Episode], motion: Motion, sound: Path | None) -> Scene | None:
    """Return the scene of arms with weight, with ideal arms in place of the demonstration's ghost.

    Both are moved by the agent that was trained on ideal arms.

    Args:
        episodes: Episodes by the titles of `SHOWN`; None where one of the two is missing.
        motion: The motion.
        sound: Sound file of the music to which the motion belongs.
    """
    ideal, heavy = (episodes.get(SHOWN["kinematic", arms]) for arms in ("kinematic", "physics"))
    if ideal is None or heavy is None:
        return None
    steps = min(len(ideal.trace), len(heavy.trace))
    trace = replace(heavy.trace.cut(0, steps), reference=ideal.trace.posture[: steps + 1])
    soundtrack = Soundtrack.of(sound, motion, steps, heavy.options.repeats)
    return Scene(trace, motion, heavy.options, sound=soundtrack)


def write_overlaid(video: Path, picture: Path, scene: Scene, progress: Progress) -> None:
    """Write the video of `overlaid` and a picture of the middle of its first labels.

    Args:
        video: The `.mp4` file.
        picture: The `.png` file.
        scene: Arms over others.
        progress: Wraps the range of frames, to show the progress.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
    """
    write_video(video, scene, progress)
    if row := _stills(replace(scene, captions=False)):
        _write_picture(picture, np.concatenate(row, axis=1))


def write_postures(path: Path, episodes: Mapping[str, Episode], motion: Motion) -> None:
    """Write a picture with a column for each episode: the arms in the middle of its first labels.

    Each label stands in the corner of its pictures.

    Args:
        path: The `.png` file.
        episodes: Episodes by their titles.
        motion: The motion; nothing is written where it has no label.

    Raises:
        RenderingError: OpenGL does not draw.
    """
    columns = []
    for title, episode in episodes.items():
        stills = _stills(Scene(episode.trace, motion, episode.options))
        columns.append(np.concatenate([_title(title), *stills]))
    if label_runs(motion.context):
        _write_picture(path, np.concatenate(columns, axis=1))


def _stills(scene: Scene) -> list[Picture]:
    """Return pictures of the middles of the first labels, with a gap to their right."""
    size = _WIDTH, _HEIGHT + STRIP_HEIGHT * scene.captions
    runs = label_runs(scene.trace.context[:-1])[:_PICTURES]
    pictures = []
    for step in ((start + end) // 2 for _, start, end in runs):
        still = replace(scene, trace=scene.trace.cut(step, step + 1), size=size)
        with contextlib.closing(episode_frames(still)) as frames:
            pictures.append(_apart(next(frames)[:_HEIGHT]))
    return pictures


def _write_picture(path: Path, picture: Picture) -> None:
    with atomic_write(path) as temporary:
        Image.fromarray(picture).save(temporary, format="png")


def _title(name: str) -> Picture:
    image = Image.new("RGB", (_WIDTH + _GAP, _TITLE), PAPER)
    font = ImageFont.load_default(15)
    ImageDraw.Draw(image).text((_WIDTH / 2, _TITLE / 2), name, INK, font, anchor="mm")
    return np.asarray(image)


def _apart(picture: Picture) -> Picture:
    """Return a picture, shape (H, W, 3), with a white gap to the right of it."""
    return np.pad(picture, ((0, 0), (0, _GAP), (0, 0)), constant_values=255)
