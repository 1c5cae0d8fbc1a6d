"""Runs that begin with what an earlier run has learned, and what is refused."""

import dataclasses
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mpma_mj
from mpma_mj.agents import MPMAConfig, SingleConfig
from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, CheckpointError
from mpma_mj.motions import Motion, ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import make_environments
from mpma_mj.training.initial_state import begin_from
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run import resume, train
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files
from tests.commands.test_outside_classes import AGENT
from tests.conftest import Refused
from tests.training.test_run import RESULTS

WriteTsv = Callable[..., Path]

SMALL = MPMAConfig(nodes=20, modules=2)
ONCE = EnvironmentOptions(repeats=1, arms="kinematic")


def backwards(labels: int = 4) -> Motion:
    """Return YMCA backwards, in a number of equal parts."""
    posture = ymca().posture[::-1].copy()
    part = np.arange(len(posture)) * labels // len(posture)
    return Motion(posture, np.eye(labels)[part], tuple(map(str, range(labels))), 20.0, "acmy", "")


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run with seed 3 that has converged."""
    run = mpma_mj.imitate("ymca", seed=3, agent=SMALL, env=ONCE, epochs=6)
    assert run.summary["converged"]
    return run.save(tmp_path_factory.mktemp("runs") / "earlier")


def test_a_run_that_begins_from_another_equals_its_agent_that_learns_on(earlier: Path) -> None:
    run = mpma_mj.imitate(backwards(), init=earlier, env=ONCE, epochs=3)
    agent = mpma_mj.load_agent(earlier)
    env = make_environments(run.config, 3, backwards())
    for epoch in range(len(run.history.rows)):
        record_epoch(env, agent, epoch)
        agent.learn()
    assert run.state.keys() == agent.state_dict().keys()
    for name, array in agent.state_dict().items():
        np.testing.assert_array_equal(run.state[name], array)


def test_it_does_not_calibrate_again_and_may_stop_after_an_epoch(earlier: Path) -> None:
    run = mpma_mj.imitate("ymca", init=earlier, epochs=3)
    (row,) = run.history.rows
    assert run.summary["converged"]
    assert (row["calibrating"], row["gain_inverse"]) == (0.0, 1.0)


@pytest.mark.parametrize("agent", ["mosaic", "hammer", "single", "adaptive", "oracle"])
def test_every_agent_that_learns_learns_on(agent: str, tmp_path: Path) -> None:
    own = RunConfig.of(agent=agent, nodes=10).agent
    first = mpma_mj.imitate("ymca", agent=own, env=ONCE, epochs=3)
    run = mpma_mj.imitate(backwards(), init=first.save(tmp_path / "first"), epochs=1)
    assert run.config.agent == first.config.agent
    for name, array in first.history.best.state.items():
        np.testing.assert_array_equal(run.history.best.state[name], array)


def test_a_plant_is_recruited_in_the_first_epoch(earlier: Path) -> None:
    env = EnvironmentOptions(repeats=1, arms="kinematic", actuator_gain=0.5)
    run = mpma_mj.imitate("ymca", init=earlier, env=env, epochs=1)
    assert run.history.rows[0]["plants"] == 2.0


def test_agent_seed_and_arms_are_those_of_the_earlier_run(earlier: Path) -> None:
    config = mpma_mj.imitate(backwards(), init=str(earlier), epochs=1).config
    assert (config.agent, config.seed, config.env.arms) == (SMALL, 3, "kinematic")
    assert config.env.repeats == EnvironmentOptions().repeats  # no part of the agent


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": 0}, "seed is 0; expected 3, as in"),
        ({"agent": "single"}, "agent is 'single'; expected 'mpma', as in"),
        ({"agent": SingleConfig(nodes=20)}, "agent is 'single'; expected 'mpma', as in"),
        ({"agent": dataclasses.replace(SMALL, modules=3)}, "modules is 3; expected 2, as in"),
        ({"agent": dataclasses.replace(SMALL, nodes=5)}, "nodes is 5; expected 20, as in"),
        ({"agent": dataclasses.replace(SMALL, max_plants=2)}, "max_plants is 2; expected 5, as"),
        (
            {"agent": dataclasses.replace(SMALL, models="posture", rule="gated")},
            "models is 'posture'; expected 'joint', as in",
        ),
        (
            {"agent": dataclasses.replace(SMALL, rule="my_rules.py:Mine")},
            "rule is 'my_rules.py:Mine'; expected 'weighted', as in",
        ),
        ({"env": EnvironmentOptions()}, "arms is 'physics'; expected 'kinematic', as in"),
        (
            {"env": dataclasses.replace(ONCE, control_timestep=0.1)},
            "control_timestep is 0.1; expected 0.05, as in",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_another_agent_or_other_arms_are_refused(
    earlier: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(BadOptionError) as error:
        mpma_mj.imitate("ymca", init=earlier, **options)
    assert message in str(error.value)
    assert "leave" in str(error.value)


@pytest.mark.parametrize("labels", [3, 5])
def test_another_number_of_labels_is_refused(earlier: Path, labels: int) -> None:
    with pytest.raises(BadOptionError, match=f"{labels} labels, as acmy has; ymca has 4"):
        mpma_mj.imitate(backwards(labels), init=earlier)


def test_a_config_that_was_changed_afterwards_is_refused(earlier: Path) -> None:
    config = begin_from(mpma_mj.imitate("ymca", env=ONCE, epochs=1).config, earlier, ())
    with pytest.raises(BadOptionError, match="nodes is 7; expected 20"):
        train(config.replace(nodes=7), 1)


def test_a_checkpoint_that_has_changed_is_refused(earlier: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(earlier, copy)
    run = mpma_mj.imitate(backwards(), init=copy, epochs=1)
    mpma_mj.imitate("ymca", agent=SMALL, env=ONCE, seed=3, epochs=1).save(copy, overwrite=True)
    with pytest.raises(CheckpointError, match=r"best\.npz: has changed since"):
        train(run.config, 1, motion=run.motion)


def test_the_config_says_where_the_run_began(earlier: Path, tmp_path: Path) -> None:
    run = mpma_mj.imitate(backwards(), init=earlier, epochs=1)
    folder = run.save(tmp_path / "run")
    init = json.loads((folder / "config.json").read_text())["config"]["init"]
    assert init["path"] == str(earlier)
    assert len(init["digest"]) == 64
    assert RunFolder(folder).read_config() == run.config


def test_bytes_after_the_end_of_a_checkpoint_change_nothing(earlier: Path, tmp_path: Path) -> None:
    longer = shutil.copytree(earlier, tmp_path / "earlier")
    with (longer / "checkpoint" / "best.npz").open("ab") as file:
        file.write(b"and more")
    own, other = (
        begin_from(RunConfig(agent=SMALL, agent_name="mpma", env=ONCE), path, ()).init
        for path in (earlier, longer)
    )
    assert own is not None
    assert other is not None
    assert own.digest == other.digest


def test_it_is_resumed_without_the_earlier_run(earlier: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(earlier, copy)
    # Noise keeps the error above the criterion.
    noisy = dataclasses.replace(ONCE, reference_noise=0.6)
    config = mpma_mj.imitate("ymca", init=copy, env=noisy, epochs=1).config
    whole, parts = RunFolder(tmp_path / "whole"), RunFolder(tmp_path / "parts")
    assert len(train(config, 3, folder=whole).history.rows) == 3
    train(config, 1, folder=parts)
    shutil.rmtree(copy)
    resume(parts, 2)
    for name in RESULTS:
        assert (whole.path / name).read_bytes() == (parts.path / name).read_bytes(), name


def test_the_command_line_takes_over_what_is_not_typed(
    earlier: Path, tmp_path: Path, write_tsv: WriteTsv
) -> None:
    out = tmp_path / "run"
    words = ["imitate", str(write_tsv()), "--init", str(earlier), "--nodes", "20", "--no-video"]
    assert main([*words, "--out", str(out), "--epochs", "1"]) == 0
    config = RunFolder(out).read_config()
    assert (config.agent, config.seed, config.env.arms) == (SMALL, 3, "kinematic")
    assert config.init is not None
    resumed = ["imitate", "--resume", str(out), "--epochs", "1", "--no-video"]
    assert main(resumed) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--seed", "0"], "--seed is 0; expected 3, as in"),
        (["--agent", "single"], "--agent is 'single'; expected 'mpma', as in"),
        (["--nodes", "50"], "--nodes is 50; expected 20, as in"),
        (["--modules=4"], "--modules is 4; expected 2, as in"),
        (["--max-plants", "1"], "--max-plants is 1; expected 5, as in"),
        (["--arms", "physics"], "--arms is 'physics'; expected 'kinematic', as in"),
        (["--control-timestep", "0.1"], "--control-timestep is 0.1; expected 0.05, as in"),
        (["--init", "nowhere"], "nowhere: is not a run"),
    ],
)
def test_the_command_line_refuses_in_one_line(
    earlier: Path, words: list[str], message: str, refused: Refused, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    refused(["imitate", "ymca", "--init", str(earlier), "--out", str(out), *words], message)
    assert not out.exists()


def test_a_resumed_run_begins_nowhere_else(earlier: Path, refused: Refused) -> None:
    message = "--resume continues in the folder of the run; leave --init out"
    refused(["imitate", "--resume", str(earlier), "--init", str(earlier)], message)


def test_a_run_without_an_epoch_is_refused(earlier: Path, tmp_path: Path, refused: Refused) -> None:
    shutil.copytree(earlier, tmp_path / "copy")
    (tmp_path / "copy" / "checkpoint" / "best.npz").unlink()
    refused(["imitate", "ymca", "--init", str(tmp_path / "copy")], "best.npz: missing;")


def test_a_config_whose_beginning_is_damaged_is_refused(
    earlier: Path, tmp_path: Path, refused: Refused
) -> None:
    folder = mpma_mj.imitate("ymca", init=earlier, epochs=1).save(tmp_path / "run")
    content = json.loads((folder / "config.json").read_text())
    content["config"]["init"]["path"] = 3
    content.pop("digest")
    data_files.write_json(folder / "config.json", content)
    refused(["imitate", "--resume", str(folder)], "config.json: damaged, or not of a run")


def test_a_run_folder_imports_no_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    (tmp_path / "my_agents.py").write_text(AGENT)
    monkeypatch.chdir(tmp_path)
    named, rest = ["--agent", "my_agents.py:Ahead"], ["--epochs", "1", "--no-video"]
    first = ["imitate", "ymca", "--arms", "kinematic", *named, "--out", "first", *rest]
    assert main(first) == 0
    again = ["imitate", "ymca", "--init", "first", "--out", "second", *rest]
    refused(again, "if you trust it, name it with --agent my_agents.py:Ahead")
    assert main([*again, *named]) == 0
    assert RunFolder(Path("second")).read_config().init is not None
