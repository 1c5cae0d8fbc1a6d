import dataclasses
import json
import pickle
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.agents import AGENTS, HAMMERConfig, MOSAICConfig, MPMAConfig
from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, CheckpointError
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training.config import RunConfig, option_types
from mpma_mj.training.config_json import OutsideConfig
from mpma_mj.training.factory import agent_of

AGENT = '''
from dataclasses import dataclass
from typing import Annotated

from mpma_mj.agents import Agent, AgentConfig
from mpma_mj.utils.validation import Bounds


@dataclass(frozen=True, kw_only=True)
class ScaledConfig(AgentConfig):
    """Config of scaled feedback.

    Attributes:
        gain: Gain of the feedback.
    """

    gain: Annotated[float, Bounds(0.0, 2.0)] = 1.0


class Scaled(Agent):
    """Feedback times a gain."""

    config_type = ScaledConfig

    def act(self, observation):
        angles, reference = observation["joint_angles"], observation["reference"]
        return self.config.gain * self.spec.feedback(angles, reference)
'''


@pytest.fixture
def outside(tmp_path: Path) -> str:
    """Return the path of a class of an agent in a file."""
    file = tmp_path / "my_agents.py"
    file.write_text(AGENT)
    return f"{file}:Scaled"


def test_every_builtin_agent_has_the_config_of_its_class() -> None:
    assert {name: kind.config_type for name, kind in AGENTS.items()} == CONFIG_TYPES
    for name, kind in CONFIG_TYPES.items():
        assert RunConfig(agent=kind()).agent_name == name


def test_flat_options_reach_their_part() -> None:
    config = RunConfig.of("a.tsv", "b.tsv", payload=1.0, latency=2, nodes=7, tempo=0.5, seed=3)
    assert config == RunConfig(
        motions=("a.tsv", "b.tsv"),
        reading=ReadingOptions(tempo=0.5),
        env=EnvironmentOptions(payload=1.0, latency=2),
        agent=MPMAConfig(nodes=7),
        seed=3,
    )
    assert config.option("latency") == 2
    assert config.options()["motions"] == ("a.tsv", "b.tsv")


def test_another_agent_takes_over_what_both_have() -> None:
    config = RunConfig.of(nodes=7, modules=3, ridge=0.5, context_signal="nothing")
    mosaic = config.replace(agent="mosaic")
    assert mosaic.agent == MOSAICConfig(nodes=7, modules=3, context_signal="nothing")
    assert config.replace(agent="hammer").agent == HAMMERConfig(
        nodes=7, ridge=0.5, context_signal="nothing"
    )


def test_sizes_that_an_agent_lacks_are_passed_over() -> None:
    assert RunConfig.of(agent="random", modules=3, nodes=7) == RunConfig.of(agent="random")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"nodez": 3}, "no option 'nodez'; did you mean nodes?"),
        ({"agent": "mosaic", "ridge": 1.0}, "mosaic has no option ridge, which mpma, hammer"),
        ({"nodes": 0}, "nodes is 0; expected a whole number from 1 to 20000"),
        ({"payload": -1}, "payload is -1; expected 0 to 1000, in kg"),
        ({"random_start": True}, "random_start is True; expected the default: training imitates"),
        ({"termination_distance": 0.3}, "termination_distance is 0.3; expected the default"),
        ({"agent": "hamster"}, "agent is 'hamster'; expected one of mpma, mosaic"),
        ({"seed": -1}, "seed is -1"),
    ],
)
def test_bad_options_are_named_as_in_python(options: dict[str, Any], message: str) -> None:
    with pytest.raises(BadOptionError) as caught:
        RunConfig.of(**options)
    assert str(caught.value).startswith(message)
    assert "--" not in str(caught.value)


@pytest.mark.parametrize("agent", CONFIG_TYPES)
def test_a_config_survives_json(agent: str) -> None:
    config = RunConfig.of(
        agent=agent,
        perturbation=(0.5, 30.0),
        reward_weights={"left_forearm": 2.0},
        locked_joint="left_elbow",
        unit="mm",
    )
    assert RunConfig.from_json(json.loads(json.dumps(config.to_json()))) == config


@pytest.mark.parametrize(
    "damage",
    [
        lambda c: c.pop("env"),
        lambda c: c["agent"].pop("nodes"),
        lambda c: c["agent"].update(nodes="many"),
        lambda c: c["env"].update(wind=3),
        lambda c: c.update(motions="ymca"),
        lambda c: c["agent"].update(name=3),
    ],
)
def test_damaged_json_is_refused(damage: Any) -> None:
    content = json.loads(json.dumps(RunConfig().to_json()))
    damage(content)
    with pytest.raises((KeyError, TypeError, ValueError)):
        RunConfig.from_json(content)


def test_json_imports_no_code_unless_the_class_is_named(outside: str) -> None:
    config = RunConfig.of(agent=outside, gain=0.5)
    content = json.loads(json.dumps(config.to_json()))
    unopened = RunConfig.from_json(content)
    assert isinstance(unopened.agent, OutsideConfig)
    with pytest.raises(CheckpointError, match=r"code that is not in this package; if you trust"):
        agent_of(unopened, load("ymca"), 0)
    assert RunConfig.from_json(content, (outside,)) == config
    assert unopened.to_json() == config.to_json()


def test_a_rule_from_outside_is_not_imported_either() -> None:
    config = RunConfig.of(rule="my_rules.py:MyRule")
    unopened = RunConfig.from_json(json.loads(json.dumps(config.to_json())))
    assert isinstance(unopened.agent, OutsideConfig)
    assert unopened.agent.outside == {"rule": "my_rules.py:MyRule"}


def test_the_config_of_an_outside_agent_travels_to_workers(outside: str) -> None:
    config = RunConfig.of(agent=outside, gain=0.5)
    assert pickle.loads(pickle.dumps(config)) == config


def test_an_outside_config_needs_the_path_of_its_agent(outside: str) -> None:
    agent = RunConfig.of(agent=outside).agent
    with pytest.raises(BadOptionError, match="expected a config of a built-in agent; give"):
        RunConfig(agent=agent)
    assert RunConfig(agent=agent, agent_name=outside).agent == agent


def test_options_have_types_without_bounds() -> None:
    types = option_types("mpma")
    assert types["nodes"] is int
    assert types["payload"] == float | tuple[float, float]
    assert "rule" not in option_types("mosaic")


def test_configs_are_known_by_their_values() -> None:
    config = RunConfig.of(reward_weights={"left_forearm": 2.0})
    assert len({config, dataclasses.replace(config), config.replace(seed=1)}) == 2


def test_an_outside_config_keeps_off_the_options_of_every_run(tmp_path: Path) -> None:
    file = tmp_path / "taken.py"
    file.write_text(AGENT.replace("gain", "payload"))
    with pytest.raises(BadOptionError, match="without payload among its options, which every run"):
        RunConfig.of(agent=f"{file}:Scaled")


@pytest.mark.parametrize(
    ("option", "path"),
    [
        ("rule", "mpma_mj.z/evil.py:E"),
        ("rule", {"class": "mpma_mj.z/evil.py:E", "options": {}}),
        ("rule", {"class": "mpma_mj.agents.learning_rules:/evil.py:E", "options": {}}),
        ("name", "mpma_mj.z/evil.py:E"),
        ("name", "mpma_mj.__main__:E"),
    ],
)
def test_no_path_in_a_file_passes_for_a_class_of_the_package(option: str, path: object) -> None:
    content = RunConfig().to_json()
    content["agent"][option] = path
    assert isinstance(RunConfig.from_json(content).agent, OutsideConfig)


def test_options_of_outside_agents_keep_their_types(tmp_path: Path) -> None:
    file = tmp_path / "typed.py"
    added = "    gain: Annotated[float, Bounds(0.0, 2.0)] = 1.0\n"
    more = (
        added
        + "    limits: tuple[float, ...] | None = None\n    gains: list[float] | None = None\n"
    )
    file.write_text(AGENT.replace(added, more))
    path = f"{file}:Scaled"
    config = RunConfig.of(agent=path).replace(limits=(1.0, 2.0), gains=[0.5])
    again = RunConfig.from_json(json.loads(json.dumps(config.to_json())), (path,))
    assert again == config
    assert again.option("limits") == (1.0, 2.0)
    assert again.option("gains") == [0.5]
