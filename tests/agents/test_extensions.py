"""Agents and learning rules from outside the package."""

import concurrent.futures
import dataclasses
import multiprocessing
import os
import sys
from pathlib import Path

import numpy as np
import pytest

from mpma_mj import load
from mpma_mj.agents import (
    AGENTS,
    MPMA,
    AgentSpec,
    LearningRule,
    MPMAConfig,
    agent_class,
    learning_rule,
)
from mpma_mj.agents.learning_rules import WeightedRule
from mpma_mj.errors import BadOptionError, StateError
from mpma_mj.training.rollout import record_epoch

AGENT = """
from __future__ import annotations
from dataclasses import dataclass
from typing import Annotated
import numpy as np
from mpma_mj.agents import Agent, AgentConfig
from mpma_mj.utils.validation import Bounds

@dataclass(frozen=True, kw_only=True)
class MyConfig(AgentConfig):
    gain: Annotated[float, Bounds(0.0, 2.0)] = 0.5

class MyAgent(Agent):
    config_type = MyConfig
    trainable = True
    offset = 0.0

    def act(self, observation):
        feedback = self.spec.feedback(observation["joint_angles"], observation["target"])
        return np.clip(self.config.gain * feedback + self.offset, -1, 1)

    def learn(self):
        self.offset += 0.01
        return {"offset": np.asarray(self.offset)}

    def state_dict(self):
        return {"offset": np.asarray(self.offset)}

    def load_state_dict(self, state):
        self.offset = state["offset"]

class Forgetful(MyAgent):
    state_dict = Agent.state_dict

class Unread(MyAgent):
    load_state_dict = Agent.load_state_dict

class Bare(MyConfig):
    size: int = 3

class Undecorated(MyAgent):
    config_type = Bare

@dataclass(frozen=True, kw_only=True)
class NeedyConfig(AgentConfig):
    size: int

class Sized(MyAgent):
    config_type = NeedyConfig

class Sleeper(Agent):
    pass

class Stranger:
    def act(self, observation): ...
    def reset(self, episode): ...

def function(): ...
number = 3
"""
RULE = """
from mpma_mj.agents import LearningRule

class MyRule(LearningRule):
    forgetting = 0.5
    models = "joint"

    def fit(self, readouts, epoch):
        target = epoch.outcome[:, None, :]
        readouts.forward.fit(epoch.forward_features, target, epoch.responsibility)

class PostureRule(MyRule):
    models = "posture"

class Needy(MyRule):
    def __init__(self, size): ...
"""
SPEC = AgentSpec(4, np.full(8, 12.0), 0.05)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in {
        "my_agents.py": AGENT,
        "my_rules.py": RULE,
        "broken.py": "import no_such_package",
        "leaving.py": "raise SystemExit('two\\nlines')",
        "garbled.py": "class:",
    }.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_an_agent_of_a_file_acts_and_learns() -> None:
    found = agent_class("my_agents.py:MyAgent")
    agent = found(found.config_type(), SPEC)
    env = load("ymca", arms="kinematic", repeats=1)
    first = record_epoch(env, agent, 0).action
    assert agent.learn() == {"offset": 0.01}
    env.task.episode = 0
    np.testing.assert_allclose(record_epoch(env, agent, 0).action[0], first[0] + 0.01)


def test_runs_end_alone_only_if_the_agent_selects_the_others() -> None:
    found = agent_class("my_agents.py:MyAgent")
    with pytest.raises(StateError, match=r"MyAgent has a state .* define select_runs"):
        found(found.config_type(), SPEC, seed=[0, 1]).select_runs(np.array([1]))
    stateless = AGENTS["open_loop"]
    stateless(stateless.config_type(), SPEC, seed=[0, 1]).select_runs(np.array([1]))


def test_the_config_of_an_outside_agent_is_checked_as_any_other() -> None:
    with pytest.raises(BadOptionError, match=r"gain is 3\.0; expected 0 to 2"):
        agent_class("my_agents.py:MyAgent").config_type(gain=3.0)  # type: ignore[call-arg]


def test_a_class_is_the_same_however_its_file_is_named(folder: Path) -> None:
    found = agent_class("my_agents.py:MyAgent")
    assert agent_class(f"{folder / 'my_agents.py'}:MyAgent") is found
    assert agent_class("../" + folder.name + "/my_agents.py:MyAgent") is found


def test_files_of_one_name_in_two_folders_are_two_modules(folder: Path) -> None:
    (folder / "other").mkdir()
    (folder / "other" / "my_agents.py").write_text(AGENT)
    first, second = (agent_class(f"{p}my_agents.py:MyAgent") for p in ("", "other/"))
    assert first is not second
    assert "my_agents" not in sys.modules


def test_a_class_of_a_module_is_found_by_its_name() -> None:
    assert agent_class("mpma_mj.agents.mpma:MPMA") is MPMA
    assert learning_rule("mpma_mj.agents.learning_rules:WeightedRule") == WeightedRule()


def _offset(name: str) -> float:
    return float(agent_class(name).offset)  # type: ignore[attr-defined]


def test_worker_processes_find_it_by_the_same_name() -> None:
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, context) as pool:
        assert pool.submit(_offset, "my_agents.py:MyAgent").result() == 0.0


def test_an_outside_rule_changes_what_it_fits_and_nothing_else() -> None:
    agent = MPMA(MPMAConfig(nodes=10, modules=2, rule="my_rules.py:MyRule"), SPEC)
    record_epoch(load("ymca", arms="kinematic", repeats=1), agent, 0)
    agent.learn()
    state = agent.state_dict()
    assert state["forward.weights"].any()
    assert not state["inverse.weights"].any()


def test_an_outside_rule_for_other_models_is_refused_by_its_name() -> None:
    path = "my_rules.py:PostureRule"
    message = f"rule is '{path}'; expected a rule for joint models; .* choose models=posture"
    with pytest.raises(BadOptionError, match=message):
        MPMA(MPMAConfig(rule=path), SPEC)
    MPMA(MPMAConfig(nodes=5, rule=path, models="posture"), SPEC)


def test_a_rule_may_be_given_as_an_instance() -> None:
    class Doubtful(WeightedRule):
        def fit(self, readouts: object, epoch: object) -> None:
            raise ArithmeticError

    rule: LearningRule = Doubtful()
    agent = MPMA(MPMAConfig(nodes=10, modules=2, rule=rule), SPEC)
    record_epoch(load("ymca", arms="kinematic", repeats=1), agent, 0)
    with pytest.raises(ArithmeticError):
        agent.learn()
    default = dataclasses.replace(WeightedRule(), forgetting=1.0)
    assert MPMAConfig(rule=default) == MPMAConfig(rule=WeightedRule())


@pytest.mark.parametrize("kind", ["pipe", "MB"])
def test_a_file_of_a_class_is_a_file_of_a_sane_size(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "agents.py"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        with path.open("wb") as file:
            file.truncate(5_000_000_000)
    with pytest.raises(BadOptionError, match=kind):
        MPMA(MPMAConfig(rule=f"{path}:Rule"), SPEC)


def test_a_config_that_names_a_path_imports_nothing() -> None:
    config = MPMAConfig(rule="no_such_file.py:Rule")
    with pytest.raises(BadOptionError, match="a file of Python, but"):
        MPMA(config, SPEC)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("my_agnets.py:MyAgent", "a file of Python, but /.*my_agnets.py: no such file"),
        ("no_such_package.part:A", r"\(ModuleNotFoundError: No module named 'no_such_package'\)"),
        ("broken.py:MyAgent", r"imported \(ModuleNotFoundError: No module named 'no_such_package"),
        ("leaving.py:MyAgent", r"imported \(SystemExit: two lines\)"),
        ("garbled.py:MyAgent", r"imported \(SyntaxError: .*garbled.py, line 1"),
        ("my_agents.py:MyAgnet", "it has no MyAgnet; did you mean MyAgent[?]"),
        ("my_agents.py:int", "it has no int"),
        ("my_agents.py:function", "a class, but function is an object of type function"),
        ("my_agents.py:number", "a class, but number is an object of type int"),
        ("my_agents.py:Sleeper", "with act, which Sleeper lacks; add it"),
        ("my_agents.py:Stranger", "with observe, .*, observes_plant, which Stranger lacks"),
        ("builtins:str", "with act, reset, .*, which str lacks"),
        ("my_agents.py:Forgetful", "an agent that defines state_dict and load_state_dict"),
        ("my_agents.py:Unread", "an agent that defines state_dict and load_state_dict"),
        ("my_agents.py:Undecorated", "whose config_type, Bare, is a frozen dataclass"),
        ("my_agents.py:Sized", "whose config_type has a default for size"),
        ("my_agents.py:", "a path such as"),
        (":MyAgent", "a path such as"),
        ("mpma_mj.agents.base:Agent", "with act, which Agent lacks"),
        ("str", "one of mpma, mosaic, .*, or the path of a class"),
        (["mpma"], "one of mpma, mosaic, .*, or the path of a class"),
    ],
)
def test_agents_that_cannot_be_are_refused_in_one_line(name: str, message: str) -> None:
    before = set(sys.modules)
    with pytest.raises(BadOptionError, match=message) as error:
        agent_class(name)
    assert error.value.option == "agent"
    assert "\n" not in str(error.value)
    left = {module for module in set(sys.modules) - before if "extension" in module}
    assert all("my_agents" in str(sys.modules[module].__file__) for module in left)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("magic", "weighted, gated, or the path of a class"),
        ("builtins:int", "with fit, partial_fit, .*, which int lacks"),
        ("my_rules.py:Needy", r"a class that is made without arguments \(.*'size'\)"),
        ("mpma_mj.agents:LearningRule", "with fit, which LearningRule lacks"),
    ],
)
def test_rules_that_cannot_be_are_refused_in_one_line(name: str, message: str) -> None:
    with pytest.raises(BadOptionError, match=message) as error:
        learning_rule(name)
    assert error.value.option == "rule"
    assert "\n" not in str(error.value)
