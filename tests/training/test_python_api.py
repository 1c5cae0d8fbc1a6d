"""Runs from Python: trained in one call, saved, and opened again."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mpma_mj
from mpma_mj.agents import MPMAConfig
from mpma_mj.agents.learning_rules import GatedRule
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, CheckpointError, RunFolderError
from mpma_mj.motions import Motion, ymca
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run import resume
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files

SMALL = MPMAConfig(nodes=10, modules=2)


class Extra(GatedRule):
    """Rule that takes what no field holds."""

    def __init__(self, extra: int) -> None:
        """Take a number."""
        super().__init__()
        object.__setattr__(self, "extra", extra)


ONCE = EnvironmentOptions(repeats=1, arms="kinematic")


@pytest.fixture(scope="module")
def run() -> mpma_mj.Run:
    return mpma_mj.imitate("ymca", seed=3, agent=SMALL, env=ONCE, epochs=4)


def test_one_call_trains_and_reports(run: mpma_mj.Run) -> None:
    assert run.summary["epochs"] == 3  # it is calibrated then, and the criteria hold
    assert run.config.seed == 3
    assert run.trace.posture.shape == (len(run.trace) + 1, 12)


def test_the_agent_repeats_the_best_epoch_to_the_bit(run: mpma_mj.Run) -> None:
    env = mpma_mj.load("ymca", seed=3, repeats=1, arms="kinematic")
    again = record_epoch(env, run.agent, int(run.summary["best_epoch"]) - 1)
    np.testing.assert_array_equal(again.action, run.trace.action)


def test_a_saved_run_is_what_the_command_writes(run: mpma_mj.Run, tmp_path: Path) -> None:
    folder = run.save(tmp_path / "run")
    assert {path.name for path in folder.iterdir()} == {
        *("checkpoint", "config.json", "figures", "metrics.csv", "summary.json", "trace.npz"),
    }
    assert RunFolder(folder).read_config() == run.config
    assert (
        json.loads((folder / "summary.json").read_text())["best_epoch"]
        == (run.summary["best_epoch"])
    )
    loaded = mpma_mj.load_agent(folder)
    for name, array in run.agent.state_dict().items():
        np.testing.assert_array_equal(loaded.state_dict()[name], array)


def test_a_loaded_agent_is_ready_to_act(run: mpma_mj.Run, tmp_path: Path) -> None:
    agent = mpma_mj.load_agent(run.save(tmp_path / "run"))
    env = mpma_mj.load("ymca", repeats=1, arms="kinematic")
    assert np.abs(agent.act(env.reset().observation)).max() <= 1.0


def test_a_run_replaces_another_only_if_told(run: mpma_mj.Run, tmp_path: Path) -> None:
    run.save(tmp_path / "run")
    with pytest.raises(RunFolderError, match="already contains a run"):
        run.save(tmp_path / "run")
    run.save(tmp_path / "run", overwrite=True)


def test_the_environment_of_training_can_be_changed() -> None:
    hard = EnvironmentOptions(repeats=1, payload=2.0, latency=1)
    easy = EnvironmentOptions(repeats=1)
    errors = [
        mpma_mj.imitate("ymca", agent=SMALL, env=env, epochs=1).summary["p_e_percent"]
        for env in (hard, easy)
    ]
    assert errors[0] > 1.5 * errors[1]


def test_a_motion_and_the_name_of_an_agent_are_taken_too() -> None:
    run = mpma_mj.imitate(ymca(), agent="mosaic", env=ONCE, epochs=1)
    assert run.config.agent_name == "mosaic"


def test_an_agent_that_does_not_learn_is_refused() -> None:
    with pytest.raises(BadOptionError, match="agent is 'random'; expected an agent that learns"):
        mpma_mj.imitate("ymca", agent="random")


def test_a_rule_with_options_is_saved_and_opened_again(tmp_path: Path) -> None:
    rule = GatedRule(inverse_rate=0.7)
    config = MPMAConfig(nodes=5, modules=2, models="posture", rule=rule)
    run = mpma_mj.imitate("ymca", agent=config, env=ONCE, epochs=1)
    folder = run.save(tmp_path / "run")
    assert RunFolder(folder).read_config().agent == config
    resumed = resume(RunFolder(folder), 1)
    assert resumed.summary["epochs"] == 2


def test_a_run_folder_calls_nothing_but_rules(tmp_path: Path) -> None:
    config = MPMAConfig(nodes=5, modules=2, models="posture", rule=GatedRule())
    folder = mpma_mj.imitate("ymca", agent=config, env=ONCE, epochs=1).save(tmp_path / "run")
    path, victim = folder / "config.json", tmp_path / "victim"
    content = data_files.read_json(path)
    call = {"class": "mpma_mj.utils.atomic_files:write_text", "options": {"path": str(victim)}}
    content["config"]["agent"]["rule"] = call
    data_files.write_json(path, content)
    with pytest.raises(CheckpointError, match="another config"):
        mpma_mj.load_agent(folder)
    assert not victim.exists()


def test_a_run_that_cannot_be_written_leaves_the_earlier_one(tmp_path: Path) -> None:
    class Nested(GatedRule):
        """Rule of no module."""

    earlier = mpma_mj.imitate("ymca", agent=SMALL, env=ONCE, epochs=1)
    folder = earlier.save(tmp_path / "run")
    config = MPMAConfig(nodes=5, modules=2, models="posture", rule=Nested())
    run = mpma_mj.imitate("ymca", agent=config, env=ONCE, epochs=1)
    with pytest.raises(BadOptionError, match="expected a rule whose class is a dataclass of a mod"):
        run.save(folder, overwrite=True)
    assert RunFolder(folder).read_config() == earlier.config


@pytest.mark.parametrize(
    ("motions", "reading", "message"),
    [
        ((), None, "no motion is given"),
        ((ymca(), "ymca"), None, "several motions are given"),
        ((ymca(),), ReadingOptions(end=2.0), "reading is given, but it is for paths"),
    ],
)
def test_wrong_motions_are_refused(
    motions: tuple[str | Motion, ...], reading: ReadingOptions | None, message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        mpma_mj.imitate(*motions, reading=reading)


def test_runs_and_motions_are_shown_in_one_line(run: mpma_mj.Run) -> None:
    assert repr(run).startswith("<Run of mpma on ymca: 3 epochs, best p_e ")
    assert repr(ymca()) == "<Motion ymca: 76 postures at 20 Hz>"


@pytest.mark.parametrize("epochs", [0, 2.5, "3"])
def test_epochs_are_a_whole_number(epochs: int) -> None:
    with pytest.raises(BadOptionError, match=f"epochs is {epochs!r}; expected a whole number"):
        mpma_mj.imitate("ymca", epochs=epochs)


def test_a_rule_with_a_constructor_of_its_own_is_not_written(tmp_path: Path) -> None:
    rule = Extra(3)
    run = mpma_mj.imitate(
        "ymca", agent=replace(SMALL, models="posture", rule=rule), env=ONCE, epochs=1
    )
    with pytest.raises(BadOptionError, match="expected a rule whose class is a dataclass of a mod"):
        run.save(tmp_path / "run")


def test_the_name_of_an_agent_stands_beside_its_config() -> None:
    with pytest.raises(
        BadOptionError, match=r"agent_name is 'a\.py:A'; expected a config as agent"
    ):
        mpma_mj.imitate("ymca", agent="mosaic", agent_name="a.py:A")
