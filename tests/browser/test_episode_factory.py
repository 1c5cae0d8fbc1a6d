"""Agents of runs and of motions, with both kinds of arms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.browser.episode_factory import EpisodeFactory, other_arms
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import RunFolderError
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, EvalCondition, evaluate
from mpma_mj.motions import ymca
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.run_folder import RunFolder


@pytest.mark.parametrize("changes", [{}, {"arms": "kinematic"}])
def test_a_live_episode_is_that_of_an_evaluation_to_the_bit(
    small_run: Path, changes: dict[str, Any]
) -> None:
    folder = RunFolder(small_run)
    factory = EpisodeFactory.of_run(folder)
    options = other_arms(factory.config.env) if changes else None
    episode = factory.make(EVALUATION_EPISODE, options)
    while not episode.is_over:
        episode.advance()
    condition = EvalCondition("live", folder.read_motion(), changes)
    (trace,) = evaluate(TrainedAgents.of_run(folder), condition)
    assert trace is not None
    assert trace.modules is not None
    moments = episode.moments
    np.testing.assert_array_equal([m.posture for m in moments], trace.posture)
    np.testing.assert_array_equal([m.reference for m in moments], trace.reference)
    found = [m.responsibility for m in moments[1:]]
    np.testing.assert_array_equal(found, trace.modules.responsibility)


def test_a_motion_without_a_run_is_followed_by_the_feedback_controller() -> None:
    episode = EpisodeFactory.of_motion(ymca()).make(0)
    assert episode.paired_models is None
    for _ in range(50):
        episode.advance()
    errors = [np.abs(m.posture - m.reference).mean() for m in episode.moments]
    assert 0.005 < np.mean(errors) < 0.2


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_the_other_arms_have_the_same_options_but_for_what_ideal_arms_lack(arms: Any) -> None:
    options = EnvironmentOptions(arms=arms, latency=2, actuator_gain=0.8, repeats=2)
    other = other_arms(options)
    assert other.arms != arms
    assert other_arms(other) == options


def test_ideal_arms_lack_mass_and_plants() -> None:
    plants = (Plant(), Plant(payload=2.0))
    heavy = EnvironmentOptions(payload=1.0, collisions=True, plants=plants, switch_every=(1.0, 2.0))
    assert other_arms(heavy) == EnvironmentOptions(arms="kinematic")


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="is not a run"):
        EpisodeFactory.of_run(RunFolder(tmp_path))
