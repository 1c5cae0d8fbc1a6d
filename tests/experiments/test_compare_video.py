"""Videos of a comparison."""

import dataclasses
import itertools
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.experiments.compare import Episode, Transfer
from mpma_mj.experiments.compare_report import SHOWN, first_episodes
from mpma_mj.experiments.compare_video import (
    overlaid,
    write_overlaid,
    write_postures,
    write_side_by_side,
)
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.visualization.scene import Scene, ideal_scene
from mpma_mj.visualization.video import episode_frames
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


@pytest.fixture
def on_robots() -> dict[str, Episode]:
    """Return ideal episodes on robots of different models."""
    trace = ideal_scene(ymca()).trace
    return {
        robot: Episode(trace, EnvironmentOptions(robot=robot), None, {})
        for robot in ("two_arm", "cmu_humanoid")
    }


@pytest.mark.usefixtures("opengl")
def test_different_models_look_next_to_each_other_as_they_do_alone(
    on_robots: dict[str, Episode],
) -> None:
    together = [episode_frames(Scene(e.trace, ymca(), e.options)) for e in on_robots.values()]
    shown = [[next(frames) for _ in range(3)] for frames in (*together, *together)][2:]
    for frames in together:
        frames.close()
    for episode, before in zip(on_robots.values(), shown, strict=True):
        alone = list(episode_frames(Scene(episode.trace.cut(0, 6), ymca(), episode.options)))[3:]
        # Below is the strip, which is drawn for another number of steps.
        np.testing.assert_array_equal(
            np.stack(before)[:, :480, 160:], np.stack(alone)[:, :480, 160:]
        )


@pytest.mark.usefixtures("opengl")
def test_robots_are_shown_at_each_of_the_first_labels(
    on_robots: dict[str, Episode], tmp_path: Path
) -> None:
    write_postures(tmp_path / "robots.png", on_robots, ymca())
    columns = np.split(iio.imread(tmp_path / "robots.png").astype(int), 2, axis=1)
    for column in columns:
        rows = np.split(column[24:], 4)
        for one, other in itertools.pairwise(rows):
            assert np.abs(one - other)[60:].max() > 100  # arms
            assert np.abs(one - other)[:80, 10:90].max() > 100  # letters
    assert np.abs(columns[0] - columns[1])[:24].max() > 100  # names
