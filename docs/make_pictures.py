"""Make the pictures of the documentation from a trained run, a comparison and a study.

python docs/make_pictures.py runs/ymca runs/compare runs/switching
"""

from __future__ import annotations

import itertools
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path

import imageio.v3 as iio
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.scene import Scene
from mpma_mj.visualization.video import episode_frames

PICTURES = Path(__file__).parent / "pictures"

Picture = NDArray[np.uint8]


def main(run: Path, comparison: Path, switching: Path) -> None:
    """Write clips of one pass through the motion, and copies of the figures."""
    folder = RunFolder(run)
    trace, motion = folder.read_trace(), folder.read_motion()
    PICTURES.mkdir(exist_ok=True)
    shown = slice(0, len(motion), 2)
    write_clip(
        PICTURES / "ymca.webp", every(episode_frames(Scene(trace, motion)), shown), (480, 432)
    )
    video = iio.imiter(comparison / "episodes.mp4")
    write_clip(PICTURES / "compare.webp", every(video, shown), (960, 240))
    video = iio.imiter(switching / "video.mp4")
    write_clip(PICTURES / "switching.webp", every(video, slice(0, None, 2)), (732, 420), 60)
    for figure in [*folder.figures.glob("*.png"), *comparison.glob("*.png")]:
        shutil.copy(figure, PICTURES / figure.name)


def every(frames: Iterable[Picture], shown: slice) -> list[Picture]:
    """Return the frames of a slice."""
    return list(itertools.islice(frames, shown.start, shown.stop, shown.step))


def write_clip(
    path: Path, frames: Iterable[Picture], size: tuple[int, int], quality: int = 85
) -> None:
    """Write frames, ten a second, width and height in pixels, as a clip that repeats."""
    small = (Image.fromarray(f).resize(size, Image.Resampling.LANCZOS) for f in frames)
    first, *rest = small
    shown = {"append_images": rest, "duration": 100, "loop": 0}
    first.save(path, save_all=True, **shown, quality=quality, method=6, minimize_size=True)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
