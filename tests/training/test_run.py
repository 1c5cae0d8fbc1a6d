"""Runs by the library: reproducible, resumable, and keeping the best epoch."""

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from mpma_mj import metrics
from mpma_mj.agents import Agent, AgentConfig, AgentSpec, MPMAConfig
from mpma_mj.agents.base import ModuleSignals
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError, CheckpointError, DivergedError, RunFolderError
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_agent, make_environments
from mpma_mj.training.history import _rank, epoch_metrics, has_converged
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run import resume, train
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.trainer import Trainer
from mpma_mj.utils import data_files
from mpma_mj.utils.data_files import FORMAT

SMALL = RunConfig.of(nodes=10, modules=2)
SMALL_AGENT = MPMAConfig(nodes=20, modules=2)
# Converges.
QUICK = RunConfig.of(nodes=50, repeats=1, arms="kinematic")
# What two equal runs have to have in common, to the byte.
RESULTS = (
    "config.json",
    "metrics.csv",
    "summary.json",
    "trace.npz",
    "checkpoint/latest.npz",
    "checkpoint/best.npz",
    "checkpoint/motion.npz",
)


def run(path: Path, config: RunConfig = SMALL, epochs: int = 3, **options: Any) -> RunFolder:
    folder = RunFolder(path)
    train(config, epochs, folder=folder, **options)
    return folder


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """Return the folder of a run of three epochs, which stays as it is."""
    return run(tmp_path_factory.mktemp("runs") / "trained")


@pytest.fixture
def folder(trained: RunFolder, tmp_path: Path) -> RunFolder:
    """Return a copy of it."""
    return RunFolder(shutil.copytree(trained.path, tmp_path / "a"))


def same(one: RunFolder, other: RunFolder) -> None:
    for name in RESULTS:
        assert (one.path / name).read_bytes() == (other.path / name).read_bytes(), name


def test_equal_seeds_give_equal_runs_to_the_byte(trained: RunFolder, tmp_path: Path) -> None:
    same(trained, run(tmp_path / "b"))


def test_other_seeds_give_other_runs(trained: RunFolder, tmp_path: Path) -> None:
    other = run(tmp_path / "b", SMALL.replace(seed=1))
    texts = [(folder.path / "metrics.csv").read_text() for folder in (trained, other)]
    assert texts[0] != texts[1]


@pytest.mark.parametrize(
    ("arms", "models"),
    [("physics", {"reference_noise": 0.25}), ("kinematic", {"models": "posture", "rule": "gated"})],
    ids=str,
)
def test_a_resumed_run_equals_an_uninterrupted_one(tmp_path: Path, arms: Any, models: Any) -> None:
    config = RunConfig.of(nodes=10, modules=2, repeats=1, arms=arms, **models)
    whole = run(tmp_path / "atomic_write", config, epochs=5)
    parts = run(tmp_path / "parts", config, epochs=2)
    resume(parts, 3)
    same(whole, parts)


def test_a_converged_run_stays_as_it_is(tmp_path: Path) -> None:
    folder = run(tmp_path / "a", QUICK, epochs=30)
    before = {name: (folder.path / name).read_bytes() for name in RESULTS}
    summary = resume(folder, 5).summary
    assert summary["converged"]
    assert {name: (folder.path / name).read_bytes() for name in RESULTS} == before


def test_training_ends_when_the_papers_criteria_hold(tmp_path: Path) -> None:
    rows: list[dict[str, float]] = []
    folder = RunFolder(tmp_path / "a")
    summary = train(QUICK, folder=folder, on_epoch=rows.append).summary
    assert summary["converged"]
    assert summary["epochs"] == len(rows) < 30
    assert [has_converged(row) for row in rows] == [False] * (len(rows) - 1) + [True]
    last = rows[-1]
    assert last["gain_inverse"] == 1.0
    assert last["gain_feedback"] < 0.15
    assert last["rp_error_percent"] < 3
    assert last["p_e_percent"] < 3


GOOD = {"gain_inverse": 1.0, "gain_feedback": 0.14, "rp_error_percent": 1.0, "p_e_percent": 1.0}


@pytest.mark.parametrize(
    ("change", "converged"),
    [
        ({}, True),
        ({"gain_inverse": 0.99}, False),
        ({"gain_feedback": 0.15}, False),
        ({"rp_error_percent": 3.0}, False),
        ({"p_e_percent": 3.0}, False),
    ],
)
def test_every_criterion_counts(change: dict[str, float], converged: bool) -> None:
    assert has_converged(GOOD | change) is converged


def test_an_expert_that_tracks_well_ranks_below_its_learner() -> None:
    learner = {"learner_acts": 1.0, "p_e_percent": 2.0}
    expert = {"learner_acts": 0.0, "p_e_percent": 0.1}
    assert has_converged(learner)
    assert not has_converged(expert)
    assert _rank(learner) < _rank(expert)


def test_feedback_that_tracks_well_ranks_below_modules_that_track() -> None:
    by_feedback = GOOD | {"gain_inverse": 0.5, "gain_feedback": 0.5, "p_e_percent": 0.1}
    uncertain = GOOD | {"rp_error_percent": 4.0, "p_e_percent": 0.5}
    order = [GOOD | {"p_e_percent": 0.9}, GOOD, uncertain, by_feedback]
    assert sorted(reversed(order), key=_rank) == order


def test_blas_runs_on_one_thread_while_training(tmp_path: Path) -> None:
    threads: list[int] = []

    def look(row: dict[str, float]) -> None:
        threads.extend(p["num_threads"] for p in threadpool_info() if p["user_api"] == "blas")

    with threadpool_limits(2, user_api="blas"):
        run(tmp_path / "a", epochs=1, on_epoch=look)
    assert set(threads) == {1}


def test_measures_compare_what_belongs_together() -> None:
    env = load("ymca")
    trace = record_epoch(env, make_agent(env, SMALL_AGENT), 0)
    predictions = np.repeat(trace.posture[1:, None], 2, axis=1)
    trace = dataclasses.replace(
        trace, modules=dataclasses.replace(trace.modules, predictions=predictions)
    )
    assert epoch_metrics(env.physics.site_positions, trace)[
        "prediction_error_percent"
    ] == pytest.approx(0.0, abs=1e-12)
    share = np.clip(trace.context[:-1], 0.01, 1)
    predictions = np.repeat(trace.posture[1:, None], 4, axis=1)
    modules = ModuleSignals(share, share, np.zeros((*share.shape, 8)), predictions)
    trace = dataclasses.replace(trace, modules=modules)
    assert epoch_metrics(env.physics.site_positions, trace)["nmi"] == pytest.approx(1.0, abs=1e-3)
    trace = dataclasses.replace(trace, posture=trace.reference)
    measures = epoch_metrics(env.physics.site_positions, trace)
    assert measures["p_e_percent"] == 0.0
    assert measures["mpkpe_m"] == 0.0


def test_settings_reach_agent_and_environment() -> None:
    config = RunConfig.of(
        nodes=17, modules=3, models="posture", rule="gated", seed=5, reference_noise=0.02, repeats=2
    )
    env = make_environments(config, config.seed, ymca())
    expected = load(ymca(), seed=5, reference_noise=0.02, repeats=2)
    agent = agent_of(config, env, config.seed)
    architecture = MPMAConfig(nodes=17, modules=3, models="posture", rule="gated")
    assert agent.config == architecture
    assert env.task.steps == expected.task.steps == 2 * len(ymca()) - 1
    first = env.reset().observation
    for name, value in expected.reset().observation.items():
        np.testing.assert_array_equal(first[name], value)
    state = make_agent(env, architecture, seed=5).state_dict()
    np.testing.assert_array_equal(
        agent.state_dict()["predictor.weights"], state["predictor.weights"]
    )


def test_a_simulation_that_diverges_is_a_failed_run(tmp_path: Path) -> None:
    env = load("ymca")

    class Wild(Agent):
        def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
            env.physics.data.qvel[:] = 1e12
            return np.zeros(8)

    wild = Wild(AgentConfig(), AgentSpec(4, np.ones(8), 0.05))
    with pytest.raises(DivergedError, match=r"epoch 3: the simulation diverged: .* 1;") as caught:
        record_epoch(env, wild, 2)
    assert caught.value.exit_code == 1


def test_the_best_epoch_is_kept_not_the_last_nor_one_of_feedback_alone() -> None:
    trainer = Trainer([QUICK], ymca())
    for _ in range(10):
        trainer.run_epoch(stop=False)
    (history,) = trainer.histories
    passed = [row for row in history.rows if row["gain_inverse"] == 1.0]
    assert history.best.row["p_e_percent"] == min(row["p_e_percent"] for row in passed)


def test_the_kept_state_dances_the_kept_trace_again(folder: RunFolder) -> None:
    config, trace = folder.read_config(), folder.read_trace()
    env = make_environments(config, config.seed, folder.read_motion())
    agent = agent_of(config, env, config.seed)
    state, meta = folder.read_checkpoint("best", config)
    agent.load_state_dict(state)
    epoch = int(meta["row"]["epoch"]) - 1
    env.task.episode = epoch
    agent.reset(epoch)
    timestep = env.reset()
    for action in trace.action:
        np.testing.assert_array_equal(agent.act(timestep.observation), action)
        timestep = env.step(action)
        agent.observe(timestep)


def test_the_run_folder_holds_what_is_promised(folder: RunFolder) -> None:
    summary = json.loads((folder.path / "summary.json").read_text())
    assert {
        "p_e_percent",
        "prediction_error_percent",
        "rp_error_percent",
        "feedback_ratio",
        "active_modules",
        "nmi",
        "modules_used",
        "repeatability",
        "epochs",
        "converged",
        "mpkpe_m",
    } <= summary.keys()
    config = json.loads((folder.path / "config.json").read_text())
    assert config["config"]["seed"] == 0
    assert {"mujoco", "numpy", "mpma-mj"} <= config["versions"].keys()
    assert summary["environment_steps"] == summary["epochs"] * 227
    modules = folder.read_trace().with_modules()
    output = modules.responsibility[:, :, None] * modules.module_actions
    assert summary["repeatability"]["module_output"] == metrics.repeatability(output, 76)
    lines = (folder.path / "metrics.csv").read_text().splitlines()
    assert len(lines) == 1 + summary["epochs"]
    trace = folder.read_trace()
    assert trace.posture.shape == (228, 12)
    assert trace.modules.responsibility.shape == (227, 2)
    assert trace.modules.module_actions.shape == (227, 2, 8)
    assert not list(folder.path.rglob(".*"))


def test_once_through_the_movement_is_enough(tmp_path: Path) -> None:
    folder = run(tmp_path / "a", RunConfig.of(nodes=10, modules=2, repeats=1), epochs=1)
    summary = json.loads((folder.path / "summary.json").read_text())
    assert summary["repeatability"] == {"responsibility": None, "module_output": None}


def test_a_trace_that_lacks_a_signal_is_refused(folder: RunFolder) -> None:
    arrays, meta = data_files.read_arrays(folder.path / "trace.npz", "trace")
    del arrays["prior"]
    data_files.write_arrays(folder.path / "trace.npz", "trace", arrays, meta)
    with pytest.raises(CheckpointError, match=r"trace\.npz: lacks prior"):
        folder.read_trace()


def test_a_folder_in_use_is_not_touched_unless_told(folder: RunFolder, tmp_path: Path) -> None:
    before = (folder.path / "metrics.csv").read_bytes()
    with pytest.raises(RunFolderError, match="overwrite replaces it, resume continues it"):
        run(tmp_path / "a", SMALL.replace(seed=9))
    assert (folder.path / "metrics.csv").read_bytes() == before
    run(tmp_path / "a", SMALL.replace(seed=9), epochs=1, overwrite=True)
    assert (folder.path / "metrics.csv").read_bytes() != before


def test_overwrite_leaves_what_is_not_the_runs(folder: RunFolder, tmp_path: Path) -> None:
    (folder.figures).mkdir()
    (folder.figures / "old.png").write_text("")
    (folder.path / "notes.txt").write_text("precious")
    run(tmp_path / "a", overwrite=True, epochs=1)
    assert (folder.path / "notes.txt").read_text() == "precious"
    assert not folder.figures.exists()


def test_a_foreign_config_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text('{"precious": 1}')
    (tmp_path / "figures").mkdir()
    with pytest.raises(RunFolderError, match="not a run"):
        run(tmp_path, overwrite=True)
    assert (tmp_path / "figures").exists()
    assert (tmp_path / "config.json").read_text() == '{"precious": 1}'


def test_overwrite_replaces_runs_only(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("precious")
    with pytest.raises(RunFolderError, match="not empty and not a run"):
        run(tmp_path, overwrite=True)
    assert (tmp_path / "thesis.txt").read_text() == "precious"
    with pytest.raises(RunFolderError, match="is a file"):
        run(tmp_path / "thesis.txt", overwrite=True)


def test_an_empty_folder_may_be_used(tmp_path: Path) -> None:
    assert (run(tmp_path, epochs=1).path / "summary.json").exists()


@pytest.mark.parametrize("name", ["latest", "best", "motion"])
def test_a_damaged_checkpoint_is_refused(folder: RunFolder, name: str) -> None:
    (folder.path / "checkpoint" / f"{name}.npz").write_bytes(b"rubbish")
    with pytest.raises(CheckpointError, match=f"{name}.npz: damaged"):
        resume(folder, 1)


def test_a_checkpoint_of_another_run_is_refused(folder: RunFolder, tmp_path: Path) -> None:
    other = run(tmp_path / "b", SMALL.replace(nodes=30), epochs=1)
    foreign = (other.path / "checkpoint" / "latest.npz").read_bytes()
    (folder.path / "checkpoint" / "latest.npz").write_bytes(foreign)
    with pytest.raises(CheckpointError, match="another config"):
        resume(folder, 1)


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        f'{{"format": {FORMAT}}}',
        f'{{"format": {FORMAT}, "config": {{"x": 1}}}}',
        f'{{"format": {FORMAT}, "config": {{"nodes": "x"}}}}',
    ],
)
def test_a_damaged_config_is_refused(folder: RunFolder, text: str) -> None:
    (folder.path / "config.json").write_text(text)
    with pytest.raises(CheckpointError, match=r"config\.json: damaged"):
        resume(folder, 1)


def test_a_run_of_another_version_is_refused(folder: RunFolder) -> None:
    path = folder.path / "config.json"
    path.write_text(path.read_text().replace(f'"format": {FORMAT}', '"format": 99'))
    with pytest.raises(
        CheckpointError,
        match=rf"format 99, written by mpma-mj .*, which reads format {FORMAT}; train again",
    ):
        resume(folder, 1)


def test_resuming_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="is not a run"):
        resume(RunFolder(tmp_path / "gone"), 1)


def test_no_epochs_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(BadOptionError, match="epochs is 0"):
        run(tmp_path / "a", epochs=0)
    assert not (tmp_path / "a").exists()


def test_what_shows_an_epoch_that_is_not_kept_any_more_is_removed(tmp_path: Path) -> None:
    folder = run(tmp_path / "a", QUICK, epochs=1)
    pictures = (folder.figures / "modules.png", folder.figures / "free_running.png")
    made = (
        folder.video,
        folder.results_of("modules"),
        folder.results_of("free_running"),
        *pictures,
    )
    folder.figures.mkdir()
    for file in made:
        file.write_text("of epoch 1")
    resume(folder, 3)
    assert folder.read_trace() is not None
    assert not any(file.exists() for file in made)
