"""The comparison of arms."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mpma_mj import load, make_agent
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.experiments.backend import open_backend
from mpma_mj.experiments.compare import (
    ARMS,
    UNTRAINED,
    CompareJob,
    Transfer,
    compare,
    jobs,
    measured,
)
from mpma_mj.experiments.compare_report import (
    as_csv,
    as_markdown,
    first_episodes,
    write_episodes,
    write_transfer,
)
from mpma_mj.motions import ymca
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.training.config import RunConfig
from mpma_mj.training.rollout import record_epoch
from tests.robots.humanoid import HUMANOID, short_dance, without_two_arm

SMALL = tuple(RunConfig.of(nodes=20, modules=2, repeats=1, seed=seed) for seed in (0, 1))


@pytest.fixture(scope="module")
def transfers() -> list[Transfer]:
    transfers = {job.trained_on: job.do() for job in jobs(SMALL, ymca(), epochs=8, fine_tune=2)}
    return [one for learned in (UNTRAINED, *ARMS) for one in transfers[learned]]


def test_every_agent_is_evaluated_on_every_kind_of_arms(transfers: list[Transfer]) -> None:
    pairs = [(one.trained_on, one.evaluated_on) for one in transfers]
    assert pairs == [(a, b) for a in (UNTRAINED, *ARMS) for b in ARMS]
    assert all(len(one.episodes) == 2 for one in transfers)
    episodes = [episode for one in transfers for episode in one.episodes if episode]
    assert {len(episode.trace.action) for episode in episodes} == {len(ymca()) - 1}


def test_a_users_arms_are_compared_as_they_are(tmp_path: Path) -> None:
    own = tmp_path / "strong.xml"
    text = read_robot("two_arm").model.read_text(encoding="utf-8")
    own.write_text(text.replace('kv="20"', 'kv="40"'), encoding="utf-8")
    config = RunConfig.of(agent="single", nodes=5, repeats=1)

    def torque(config: RunConfig) -> float:
        job = CompareJob(UNTRAINED, (config,), ymca(), epochs=1, fine_tune=1)
        return job.do()[1].values("mean_torque_nm")[0]

    assert torque(config.replace(robot=str(own))) > 1.1 * torque(config)


def test_workers_bring_the_same_in_the_same_order(transfers: list[Transfer]) -> None:
    with open_backend("processes", 2, None) as backend:
        found = compare(jobs(SMALL, ymca(), epochs=8, fine_tune=2), backend)
    assert as_csv(found) == as_csv(transfers)


def test_feedback_alone_is_a_step_behind_and_trained_agents_are_not(
    transfers: list[Transfer],
) -> None:
    for one in transfers:
        expected = 50.0 if one.trained_on == UNTRAINED else 0.0
        assert one.values("lag_ms") == pytest.approx([expected] * 2, abs=15.0)
        if one.trained_on == UNTRAINED:
            assert np.isnan(one.fine_tuned).all()
            assert one.values("feedback_ratio") == pytest.approx([1.0] * 2)
        else:
            assert np.isfinite(one.fine_tuned).all()


def test_weight_costs_torque_and_ideal_arms_have_none(transfers: list[Transfer]) -> None:
    torque = {(c.trained_on, c.evaluated_on): c.values("mean_torque_nm") for c in transfers}
    for learned in (UNTRAINED, *ARMS):
        assert torque[learned, "kinematic"] == []
        assert min(torque[learned, "physics"]) > max(torque[learned, "compensated"]) > 0.0


def test_tables_have_a_row_for_each_pair_and_each_agent(transfers: list[Transfer]) -> None:
    lines = as_markdown(transfers, 2).splitlines()
    assert lines[0].startswith("| trained on | evaluated on | epochs | p_e, % | after 2 epochs |")
    assert sum(line.startswith("| nothing |") for line in lines) == 3
    assert lines[2].count("–") == 5  # epochs, adapted, torques and work
    rows = list(csv.DictReader(as_csv(transfers).splitlines()))
    assert len(rows) == 12 * 2
    of_last = transfers[-1].episodes[1]
    assert of_last is not None
    assert float(rows[-1]["p_e_percent"]) == of_last.measures["p_e_percent"]
    assert rows[0]["work_j"] == rows[0]["fine_tuned_p_e_percent"] == rows[0]["epochs"] == ""


def test_an_episode_that_diverged_counts_in_no_mean(transfers: list[Transfer]) -> None:
    last = transfers[-1]
    lost = Transfer(
        last.trained_on,
        last.evaluated_on,
        last.seeds,
        last.epochs,
        (None, last.episodes[1]),
        last.fine_tuned,
    )
    table = as_markdown([*transfers[:-1], lost], 2)
    assert "1 of 24 episodes diverged; they count in no mean." in table
    assert len(lost.values("p_e_percent")) == 1
    assert "diverged" not in as_markdown(transfers, 2)


def test_a_motion_without_repetition_is_drawn(transfers: list[Transfer], tmp_path: Path) -> None:
    write_episodes(tmp_path / "episodes.png", transfers, ymca())
    assert (tmp_path / "episodes.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.filterwarnings("error")
def test_where_all_diverged_there_are_figures_and_no_episodes(
    transfers: list[Transfer], tmp_path: Path
) -> None:
    lost = [
        dataclasses.replace(one, episodes=(None, None), fine_tuned=np.full(2, np.nan))
        for one in transfers
    ]
    assert first_episodes(lost) == {}
    write_transfer(tmp_path / "transfer.png", lost, 2)
    write_episodes(tmp_path / "episodes.png", lost, ymca())
    assert "24 of 24 episodes diverged" in as_markdown(lost, 2)


def test_joint_errors_are_those_of_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    motion, options = short_dance(), EnvironmentOptions(robot=HUMANOID, repeats=1)
    without_two_arm(monkeypatch)
    env = load(motion, robot=HUMANOID, repeats=1)
    trace = record_epoch(env, make_agent(env, kind="resolved_rate"), 0)
    arms = PhysicsArms.make(options)
    measures = measured(trace, options, motion.rate, arms).measures
    errors = [measures[f"rms_{joint}_deg"] for joint in arms.kinematics.joint_names]
    assert 0.0 < min(errors) <= max(errors) < 10.0
