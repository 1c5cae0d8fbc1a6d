"""Strip below the frames of a video: responsibilities and labels over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mpma_mj.context import active_label
from mpma_mj.visualization.colours import INK, PAPER, hex_to_rgb, module_colours

__all__ = ["LABEL_SIZE", "STRIP_HEIGHT", "Strip", "label_runs"]

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_BAND = 22  # height of the row of labels, pixels
_LEGEND = 18  # height of the legend of modules, pixels
_MOST_NAMED_MODULES = 7  # with more modules the legend has numbers only
STRIP_HEIGHT = 96
"""Height of the strip, pixels."""

_TALL = "fl"  # as high as most labels
LABEL_SIZE = 72
"""Size of the label in the corner of a frame, pixels."""


class Strip:
    """Responsibilities as stacked bands in the colours of modules over time, below their labels.

    All but the mark of the current step is drawn once.
    """

    def __init__(
        self,
        responsibility: Array,
        context: Array,
        labels: tuple[str, ...],
        bands: tuple[str, ...],
        *,
        width: int = 640,
        height: int = STRIP_HEIGHT,
    ) -> None:
        """Draw the whole epoch.

        Args:
            responsibility: Responsibilities λ, shape (T, M), or other shares.
            context: Context, shape (T, C).
            labels: Label of each entry of the context, C of them.
            bands: Names of the M bands.
            width: Width, pixels.
            height: Height, pixels.
        """
        self._steps = len(responsibility)
        self._label = active_label(context)
        self._strip = _draw_strip(responsibility, context, labels, bands, width, height)
        self._label_masks = [_label_mask(label, width // 2) for label in labels]

    def under(self, picture: Picture, step: int) -> Picture:
        """Return a picture with the strip below it and the active label in its corner.

        Args:
            picture: Picture, shape (H, W, 3); W is the width of the strip.
            step: Current step, from 0.

        Returns:
            Picture, shape (H + height, W, 3).
        """
        frame = np.concatenate([picture, self._strip])
        now = round((step + 0.5) / self._steps * (frame.shape[1] - 1))
        frame[len(picture) + _BAND : -_LEGEND, max(now - 1, 0) : now + 2] = hex_to_rgb(INK)
        if self._label[step] < 0:
            return frame
        opacity = self._label_masks[self._label[step]]
        corner = frame[16 : 16 + opacity.shape[0], 20 : 20 + opacity.shape[1]]
        blended = corner * (1.0 - opacity) + np.array(hex_to_rgb(INK)) * opacity
        corner[...] = blended.astype(np.uint8)
        return frame


def label_runs(context: Array) -> list[tuple[int, int, int]]:
    """Return the stretches of constant label as (label, first step, step after the last).

    Args:
        context: Context, shape (T, C).
    """
    label = active_label(context)
    starts = np.flatnonzero(np.diff(label, prepend=-2))
    ends = np.append(starts[1:], len(label))
    runs = zip(label[starts], starts, ends, strict=True)
    return [(int(label), int(start), int(end)) for label, start, end in runs if label >= 0]


def _draw_strip(
    responsibility: Array,
    context: Array,
    labels: tuple[str, ...],
    names: Sequence[str],
    width: int,
    height: int,
) -> Picture:
    """Return the strip, shape (height, width, 3)."""
    steps, modules = responsibility.shape
    colours = module_colours(modules)
    image = Image.new("RGB", (width, height), PAPER)
    image.paste(_bands(responsibility, colours, width, height - _BAND - _LEGEND), (0, _BAND))
    draw = ImageDraw.Draw(image)
    small = ImageFont.load_default(13)
    for label, start, end in label_runs(context):
        left, right = (start / steps * width, end / steps * width)
        draw.line((left, 0, left, height - _LEGEND), fill=INK)
        if draw.textlength(labels[label], small) < right - left:
            draw.text(((left + right) / 2, _BAND / 2), labels[label], INK, small, anchor="mm")
    x = 8.0
    for number, colour in enumerate(colours, start=1):
        name = names[number - 1] if modules <= _MOST_NAMED_MODULES else str(number)
        draw.rectangle((x, height - 14, x + 10, height - 4), fill=colour)
        draw.text((x + 15, height - _LEGEND / 2), name, INK, small, anchor="lm")
        x += 24 + draw.textlength(name, small)
    return np.asarray(image)


def _bands(responsibility: Array, colours: list[str], width: int, height: int) -> Image.Image:
    """Return stacked bands: in each column the height of a band is the module's responsibility."""
    step = np.arange(width) * len(responsibility) // width
    tops = np.cumsum(responsibility[step], axis=1)  # (width, M)
    level = (np.arange(height)[::-1] + 0.5) / height
    module = (level[:, None, None] > tops[None]).sum(axis=2)  # (height, width)
    palette = np.array([hex_to_rgb(colour) for colour in colours], np.uint8)
    return Image.fromarray(palette[np.minimum(module, len(colours) - 1)])


def _label_mask(label: str, width: int) -> Array:
    """Return the opacity of a large label, shape (h, w, 1), in [0, 1]; w is at most a width."""
    full_width = ImageFont.load_default(LABEL_SIZE).getlength(label)
    font = ImageFont.load_default(LABEL_SIZE * min(1.0, width / max(full_width, 1.0)))
    left, _, right, bottom = font.getbbox(label)
    top = min(font.getbbox(letters)[1] for letters in (_TALL, label))  # labels share a line
    image = Image.new("L", (round(right - left), round(bottom - top)))
    ImageDraw.Draw(image).text((-left, -top), label, 255, font)
    return np.asarray(image, np.float64)[:, :, None] / 255.0
