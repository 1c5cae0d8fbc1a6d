"""Agents and rules of a third person, named on the command line by their files."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.utils import data_files
from tests.conftest import Refused

AGENT = '''
import numpy as np

from mpma_mj.agents import Agent


class Ahead(Agent):
    """Feedback towards the next posture, with a learned bias."""

    trainable = fine_tunable = True

    def __init__(self, config, spec, *, seed=0):
        super().__init__(config, spec, seed=seed)
        self.bias = np.zeros((*np.shape(seed), 8))

    def act(self, observation):
        action = self.spec.feedback(observation["joint_angles"], observation["target"])
        return np.clip(action + self.bias, -1, 1)

    def learn(self):
        self.bias = self.bias + 1e-3
        return {"bias": self.bias.mean(axis=-1)}

    def state_dict(self):
        return {"bias": self.bias.copy()}

    def load_state_dict(self, state):
        self.bias = state["bias"].copy()

    def select_runs(self, runs):
        self.bias = self.bias[runs]


class Still:
    """Lacks all methods."""
'''

RULE = '''
from mpma_mj.agents.learning_rules import WeightedRule


class Mine(WeightedRule):
    """The weighted rule by another name."""
'''

SMALL = ("--repeats", "1", "--no-video", "--arms", "kinematic")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory, which has files of an agent and of a rule."""
    (tmp_path / "my_agents.py").write_text(AGENT)
    (tmp_path / "my_rules.py").write_text(RULE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def imitate(*words: str) -> int:
    return main(["imitate", *words, *SMALL])


def test_an_outside_agent_is_trained_resumed_and_evaluated(here: Path, refused: Refused) -> None:
    named = ("--agent", "my_agents.py:Ahead")
    assert imitate("ymca", *named, "--epochs", "2", "--out", "run") == 0
    config = json.loads((here / "run" / "config.json").read_text())["config"]
    assert config["agent"] == {"name": "my_agents.py:Ahead"}
    assert (here / "run" / "figures" / "trajectory.png").exists()
    assert main(["imitate", "--resume", "run", *named, "--epochs", "1", "--no-video"]) == 0
    evaluate = ("evaluate", "run", "--disturbances", "payload", "--levels", "1")
    assert main([*evaluate, *named]) == 0


def test_a_run_folder_imports_no_code_that_is_not_named(here: Path, refused: Refused) -> None:
    assert imitate("ymca", "--agent", "my_agents.py:Ahead", "--epochs", "1", "--out", "run") == 0
    trap = here / "imported"
    (here / "my_agents.py").write_text(f"open({str(trap)!r}, 'w')\n" + AGENT)
    message = "code that is not in this package; if you trust it, name it with --agent my_agents.py"
    refused(["imitate", "--resume", "run", "--no-video"], message)
    refused(["evaluate", "run"], message)
    assert not trap.exists()


def test_an_outside_rule_is_trained_and_named_again(here: Path, refused: Refused) -> None:
    words = ("--rule", "my_rules.py:Mine", "--nodes", "5", "--modules", "2")
    assert imitate("ymca", *words, "--epochs", "3", "--out", "run") == 0
    refused(["analyse", "run", "lesion"], "name it with --rule my_rules.py:Mine")
    assert main(["analyse", "run", "lesion", "--fine-tune", "0", "--rule", "my_rules.py:Mine"]) == 0


def test_an_outside_agent_stands_in_the_table_of_agents(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = (
        "study agents --agents mpma my_agents.py:Ahead --nodes 5 --runs 2 --epochs 2 --out table"
    )
    assert main([*words.split(), "--workers", "2"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if "my_agents.py:Ahead" in line]
    assert len(rows) == 2  # kinds of arms


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("gone.py:Ahead", "--agent is 'gone.py:Ahead'; expected a file of Python, but"),
        ("my_agents.py:Ahed", "a class of my_agents.py, but it has no Ahed; did you mean Ah"),
        ("my_agents.py:Still", "a class with act, reset, observe, learn, signals"),
        ("my_agents.py:np", "expected a class, but np is an object of type module"),
        ("json:loads", "expected a class, but loads is an object of type function"),
        ("no.such.module:Ahead", "expected a module that can be imported (ModuleNotFoundError"),
        ("Ahead", "expected one of mpma, mosaic, hammer"),
    ],
)
def test_a_wrong_path_of_an_agent_is_one_line(
    path: str, message: str, here: Path, refused: Refused
) -> None:
    refused(["imitate", "ymca", "--agent", path, "--out", "run"], message)
    assert not (here / "run").exists()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("gone.py:Mine", "--rule is 'gone.py:Mine'; expected a file of Python, but"),
        ("my_rules.py:Yours", "a class of my_rules.py, but it has no Yours"),
        ("my_agents.py:Still", "a class with fit"),
        ("mine", "--rule is 'mine'; expected weighted, gated, or the path of a class"),
    ],
)
def test_a_wrong_path_of_a_rule_is_one_line(
    path: str, message: str, here: Path, refused: Refused
) -> None:
    refused(["imitate", "ymca", "--rule", path, "--out", "run"], message)


@pytest.mark.parametrize("form", [str, lambda path: f"--agent={path}"])
def test_options_of_other_agents_are_refused_by_name(
    form: Callable[[str], str], refused: Refused
) -> None:
    words = ["--agent", "hammer"] if form is str else [form("hammer")]
    message = "hammer has no option --rule; leave it out, or choose another --agent: mpma, single"
    refused(["imitate", "ymca", *words, "--rule", "gated"], message)


def test_a_config_of_an_earlier_format_names_its_writer(tmp_path: Path, refused: Refused) -> None:
    content = {"format": 3, "versions": {"mpma-mj": "0.0.9"}, "config": {"arms": "physics"}}
    data_files.write_json(tmp_path / "config.json", content)
    message = "config.json: format 3, written by mpma-mj 0.0.9; this is"
    refused(["play", str(tmp_path)], message)
    refused(["imitate", "--resume", str(tmp_path)], message)


def test_an_agent_that_logs_nothing_learns_in_every_epoch(here: Path) -> None:
    (here / "silent.py").write_text(AGENT.replace('{"bias": self.bias.mean(axis=-1)}', "{}"))
    assert imitate("ymca", "--agent", "silent.py:Ahead", "--epochs", "3", "--out", "run") == 0
    assert len((here / "run" / "metrics.csv").read_text().splitlines()) == 1 + 3


@pytest.mark.parametrize("named", [("--agent", "mosaic"), ("--rule", "my_rules.py:Mine")])
def test_a_class_is_named_only_for_runs_that_were_trained_with_it(
    named: tuple[str, str], here: Path, refused: Refused, small_run: Path
) -> None:
    message = f"{named[0]} is '{named[1]}'; expected the path of a class from outside with which a"
    for command in (["analyse", "lesion"], ["analyse", "free-running"], ["evaluate"]):
        refused([*command, str(small_run), *named], message)
