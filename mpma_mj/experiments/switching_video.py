"""Video of the study `switching`: an episode with several agents next to each other."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.experiments.records import Record
from mpma_mj.visualization.colours import INK, PAPER, hex_to_rgb, module_colours
from mpma_mj.visualization.video import Progress, write_frames

__all__ = ["smoothed_error", "write_video"]

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

# Pixels of an agent's part of the video; the height of all is even, which encoders take.
_WIDTH, _ARMS, _TITLE = 480, 360, 32
_GAP = 8  # to the right of each
_PLANTS, _ERRORS, _SHARES = 24, 104, 40
_FINE = 2  # size in which curves are drawn, before they are scaled down
_SMOOTHED = 5  # steps over which errors are averaged
_TINT = 0.18  # opacity of plants behind errors
_HEADROOM = 1.15  # top of the errors' axis over the largest
_UNMATCHED = "#b9bec7"  # plants of the agent that answer for no true one


def write_video(
    path: Path,
    episodes: Mapping[str, Record],
    plants: Sequence[str],
    options: EnvironmentOptions,
    progress: Progress,
) -> None:
    """Write the video of an episode in which plants switch unannounced.

    Args:
        path: The `.mp4` file.
        episodes: What `SwitchingJob` keeps of each agent's episode, by titles; of one length.
        plants: Names of the plants.
        options: Options of the environment with these plants, whose arms are drawn.
        progress: Wraps the range of frames, to show the progress.

    Raises:
        RenderingError: OpenGL does not draw.
        VideoError: The encoder is missing, or fails.
    """
    first = next(iter(episodes.values()))
    top = _HEADROOM * max(smoothed_error(episode).max() for episode in episodes.values())
    with contextlib.ExitStack() as stack:
        parts = [
            stack.enter_context(contextlib.closing(_Part(title, episode, plants, options, top)))
            for title, episode in episodes.items()
        ]
        steps = progress(range(len(first["plant"])))
        frames = (np.hstack([part.frame(step) for part in parts]) for step in steps)
        write_frames(path, frames, first["rate"])


def smoothed_error(episode: Record) -> Array:
    """Return the error around each step of an episode, shape (T,), percent."""
    error = np.array(episode["error"])
    return np.convolve(error, np.full(_SMOOTHED, 1.0 / _SMOOTHED), "same")


class _Part:
    """One agent's part of the video: title with the error, arms, and what happens over time."""

    def __init__(
        self,
        title: str,
        episode: Record,
        plants: Sequence[str],
        options: EnvironmentOptions,
        top: float,
    ) -> None:
        self._title = title
        self._episode, self._error = episode, smoothed_error(episode)
        self._joint_angles = np.array(episode["joint_angles"])
        self._reference = np.array(episode["reference"])
        self._arms = PhysicsArms.make(options)
        self._renderer = ArmRenderer(self._arms, width=_WIDTH, height=_ARMS)
        self._curves = _curves(episode, plants, self._error, top)

    def frame(self, step: int) -> Picture:
        """Draw a step, from 0; shape (height, width, 3)."""
        self._arms.set_joint_state(self._joint_angles[step], np.zeros(8))
        self._arms.set_plant(self._episode["plant"][step])
        arms = self._renderer.picture(ghost=self._reference[step])
        curves = self._curves.copy()
        now = round((step + 0.5) / len(self._error) * (_WIDTH - 1))
        curves[:, max(now - 1, 0) : now + 1] = hex_to_rgb(INK)
        part = np.concatenate([self._header(step), arms, curves])
        return np.pad(part, ((0, 0), (0, _GAP), (0, 0)), constant_values=255)

    def close(self) -> None:
        self._renderer.close()

    def _header(self, step: int) -> Picture:
        image = Image.new("RGB", (_WIDTH, _TITLE), PAPER)
        draw, font = ImageDraw.Draw(image), ImageFont.load_default(16)
        draw.text((10, _TITLE / 2), self._title, INK, font, anchor="lm")
        error = f"error {self._error[step]:.1f} %"
        draw.text((_WIDTH - 10, _TITLE / 2), error, INK, font, anchor="rm")
        return np.asarray(image)


def _curves(episode: Record, plants: Sequence[str], error: Array, top: float) -> Picture:
    """Draw true plants, the error over time, and below them the responsibilities of plants."""
    plant, colours = np.array(episode["plant"]), module_colours(len(plants))
    size = _WIDTH * _FINE, (_PLANTS + _ERRORS + _SHARES) * _FINE
    image = Image.new("RGB", size, PAPER)
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(13 * _FINE)
    across = np.arange(len(plant) + 1) / len(plant) * size[0]
    band, floor = _PLANTS * _FINE, (_PLANTS + _ERRORS) * _FINE
    starts = np.flatnonzero(np.diff(plant, prepend=-1))
    for start, end in zip(starts, [*starts[1:], len(plant)], strict=True):
        colour, (left, right) = colours[plant[start]], across[[start, end]].tolist()
        draw.rectangle((left, 0, right, band), colour)
        draw.rectangle((left, band, right, floor), _paler(colour))
        if draw.textlength(plants[plant[start]], font) < right - left:
            middle = (left + right) / 2, band / 2
            draw.text(middle, plants[plant[start]], PAPER, font, anchor="mm")
    heights = floor - error / top * _ERRORS * _FINE
    middles = (across[:-1] + across[1:]) / 2
    draw.line(list(zip(middles.tolist(), heights.tolist(), strict=True)), INK, 2 * _FINE)
    for share, below, colour in _stack(episode, colours):
        tops, bases = (floor + (1.0 - edge) * _SHARES * _FINE for edge in (share, below))
        for step in range(len(plant)):
            draw.rectangle((across[step], tops[step], across[step + 1], bases[step]), colour)
    if "responsibility" not in episode:
        place = size[0] / 2, floor + _SHARES * _FINE / 2
        draw.text(place, "no modules", INK, font, anchor="mm")
    return np.asarray(image.resize((_WIDTH, size[1] // _FINE), Image.Resampling.LANCZOS))


def _stack(episode: Record, colours: Sequence[str]) -> list[tuple[Array, Array, str]]:
    """Return top, base and colour of the stacked responsibilities of plants, as shares."""
    if "responsibility" not in episode:
        return []
    share = np.array(episode["responsibility"])
    share = share.reshape(len(share), -1, episode["modules"]).sum(axis=2)
    hues = dict(zip(episode["matched"], colours, strict=True))
    order = sorted(range(share.shape[1]), key=lambda found: found not in hues)
    tops = np.cumsum(share[:, order], axis=1)
    return [
        (tops[:, place], tops[:, place] - share[:, found], hues.get(found, _UNMATCHED))
        for place, found in enumerate(order)
    ]


def _paler(colour: str) -> tuple[int, int, int]:
    red, green, blue = (round(255 - _TINT * (255 - value)) for value in hex_to_rgb(colour))
    return red, green, blue
