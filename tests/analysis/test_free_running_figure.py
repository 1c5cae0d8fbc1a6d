"""The picture of a dance without its demonstration: what of it is drawn."""

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.analysis.free_running import FreeRun
from mpma_mj.analysis.free_running_report import drawn_spans, write_figure
from mpma_mj.motions import ymca

PERIOD = 40


def dance(rate: float) -> FreeRun:
    """Return arms that stay where they are, shape (3 * PERIOD, 12)."""
    phase = 2.0 * np.pi * np.arange(3 * PERIOD) / PERIOD
    one = np.stack([np.cos(phase), np.sin(phase), np.zeros_like(phase)], axis=1)
    shown = np.tile(one, 4)
    still = np.repeat(shown[:1], len(shown), axis=0)
    return FreeRun(still, shown, np.zeros(len(shown), int), PERIOD, rate)


def test_of_a_long_dance_the_first_and_the_last_repetition_are_drawn() -> None:
    assert drawn_spans(dance(20.0)) == [slice(0, 120)]
    assert drawn_spans(dance(2.0)) == [slice(0, 40), slice(80, 120)]


@pytest.mark.parametrize("rate", [20.0, 2.0])
def test_the_picture_shows_something_however_long_the_dance(rate: float, tmp_path: Path) -> None:
    path = tmp_path / "free_running.png"
    write_figure(path, dance(rate), ymca())
    assert iio.imread(path).std() > 10
