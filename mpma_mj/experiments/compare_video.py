"""The comparison of arms as a video: all of them side by side."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mpma_mj.experiments.compare import Dance
from mpma_mj.motions import Motion
from mpma_mj.visualization.colours import INK, PAPER
from mpma_mj.visualization.video import Progress, dance_frames, write_frames

__all__ = ["write_side_by_side"]

Picture = NDArray[np.uint8]

# Pixels. With gap, title and strip it is 480 x 480, which encoders take.
_WIDTH, _HEIGHT, _GAP, _TITLE = 472, 360, 8, 24


def write_side_by_side(
    path: Path, dances: Mapping[str, Dance], motion: Motion, progress: Progress
) -> None:
    """Draw dances beside each other, each with ghost, letters and responsibilities.

    Args:
        path: The `.mp4` file.
        dances: Dances of the same length by what stands above them.
        motion: The movement.
        progress: Wraps the range of frames, to show how far it is.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
    """
    titles = np.concatenate([_title(name) for name in dances], axis=1)
    steps = range(min(len(dance.trace.action) for dance in dances.values()))
    with contextlib.ExitStack() as stack:
        size = _WIDTH, _HEIGHT
        films = [
            stack.enter_context(
                contextlib.closing(
                    dance_frames(dance.trace, motion, options=dance.options, size=size)
                )
            )
            for dance in dances.values()
        ]
        frames = (
            np.concatenate([titles, np.concatenate([_apart(next(film)) for film in films], axis=1)])
            for _ in progress(steps)
        )
        write_frames(path, frames, motion.rate)


def _title(name: str) -> Picture:
    image = Image.new("RGB", (_WIDTH + _GAP, _TITLE), PAPER)
    font = ImageFont.load_default(15)
    ImageDraw.Draw(image).text((_WIDTH / 2, _TITLE / 2), name, INK, font, anchor="mm")
    return np.asarray(image)


def _apart(picture: Picture) -> Picture:
    """Return a picture, shape (H, W, 3), with a white gap to the right of it."""
    return np.pad(picture, ((0, 0), (0, _GAP), (0, 0)), constant_values=255)
