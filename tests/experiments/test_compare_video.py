"""Videos of a comparison."""

import dataclasses
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.experiments.compare import Transfer
from mpma_mj.experiments.compare_report import SHOWN, first_episodes
from mpma_mj.experiments.compare_video import overlaid, write_overlaid, write_side_by_side
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from tests.experiments.test_compare import transfers

__all__ = ["transfers"]  # the fixture


@pytest.mark.usefixtures("opengl")
def test_the_video_has_all_arms_side_by_side_and_every_step(
    transfers: list[Transfer], tmp_path: Path
) -> None:
    episodes = {}
    for name, episode in first_episodes(transfers).items():
        cut = len(episode.trace) - 6
        signals = {name: signal[:-cut] for name, signal in episode.trace.to_arrays().items()}
        episodes[name] = dataclasses.replace(episode, trace=Trace.from_arrays(signals))
    path = tmp_path / "episodes.mp4"
    write_side_by_side(path, episodes, ymca(), iter)
    frames = iio.imread(path).astype(int)
    assert frames.shape == (6, 480, 4 * 480, 3)
    panels = np.split(frames[0], 4, axis=1)
    # Ideal arms stand elsewhere than heavy ones only a little, but their titles are others.
    assert all(np.abs(panels[0][:24] - panel[:24]).max() > 100 for panel in panels[1:])
    assert all(panel[24:384].std() > 10 for panel in panels)


@pytest.mark.usefixtures("opengl")
def test_heavy_arms_are_drawn_over_the_ideal_ones_of_the_same_agent(
    transfers: list[Transfer], tmp_path: Path
) -> None:
    episodes = first_episodes(transfers)
    whole = overlaid(episodes, ymca(), None)
    assert whole is not None
    ideal, heavy = (episodes[SHOWN["kinematic", arms]].trace for arms in ("kinematic", "physics"))
    np.testing.assert_array_equal(whole.trace.reference, ideal.posture)
    np.testing.assert_array_equal(whole.trace.posture, heavy.posture)
    video, picture = tmp_path / "overlaid.mp4", tmp_path / "overlaid.png"
    write_overlaid(video, picture, whole.cut(0.0, 2.0), iter)
    assert len(list(iio.imiter(video))) == 40
    assert iio.imread(picture).shape == (360, 3 * 480, 3)  # Y, M and C begin in two seconds


def test_without_one_of_the_two_nothing_is_overlaid(transfers: list[Transfer]) -> None:
    episodes = first_episodes(transfers)
    del episodes[SHOWN["kinematic", "physics"]]
    assert overlaid(episodes, ymca(), None) is None
