"""Clips and detectors for tests without mediapipe: what is found in each frame is given."""

from __future__ import annotations

import contextlib
import subprocess
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from mpma_mj.motions.readers.video.detector import Detector, Pose

Array = NDArray[np.float64]

WIDTH, HEIGHT, RATE = 640, 480, 20.0  # of what is looked at, whatever the clip's own size
FRAMES = 40


def ffmpeg(*options: str) -> None:
    """Run ffmpeg."""
    program = imageio_ffmpeg.get_ffmpeg_exe()
    subprocess.run([program, "-v", "error", "-y", *options], check=True, timeout=60)


def write_colours(path: Path, seconds: float = FRAMES / RATE, *, size: str = "64x48") -> Path:
    """Write a video without a person."""
    source = f"testsrc=size={size}:rate={RATE:g}:duration={seconds}"
    ffmpeg("-f", "lavfi", "-i", source, "-pix_fmt", "yuv420p", str(path))
    return path


def pose_of(
    angles: Sequence[float],
    forward: Sequence[float] = (0.0,) * 4,
    *,
    middle: tuple[float, float] = (320.0, 240.0),
    scale: float = 200.0,
) -> Pose:
    """Return the pose of a person who faces the camera, seen in parallel.

    Args:
        angles: Of upper arm and forearm, left and right, in the picture, degrees: 0 down, 90
            outwards, 180 up.
        forward: Of the same out of the picture, towards the camera, degrees.
        middle: Of the hips, pixels.
        scale: Pixels of a metre.
    """
    places = []
    for side, outwards in enumerate((1.0, -1.0)):  # a left hand is at the right of the picture
        place = np.array([0.18 * outwards, -0.5, 0.0])
        places.append(place)
        for segment, length in enumerate((0.3, 0.25)):
            a, f = np.radians([angles[2 * side + segment], forward[2 * side + segment]])
            way = [outwards * np.sin(a) * np.cos(f), np.cos(a) * np.cos(f), -np.sin(f)]
            place = place + length * np.array(way)
            places.append(place)
        places.append(np.array([0.1 * outwards, 0.0, 0.0]))
    space = np.array(places)
    pixels = space[:, :2] * scale + middle
    extent = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
    return Pose(pixels, space, np.ones(len(space)), extent)


class GivenPoses:
    """A detector that finds given poses, one after the other; the last one again and again."""

    def __init__(self, poses: Sequence[Pose | None], others: Callable[[int], bool]) -> None:
        self._poses, self._others = poses, others
        self.looked = 0

    def find(self, picture: NDArray[np.uint8]) -> Pose | None:
        self.looked += 1
        return self._poses[min(self.looked, len(self._poses)) - 1]

    def find_other(self, picture: NDArray[np.uint8], pose: Pose) -> bool:
        return self._others(self.looked - 1)

    @contextlib.contextmanager
    def open(self, path: Path) -> Iterator[Detector]:
        yield self
