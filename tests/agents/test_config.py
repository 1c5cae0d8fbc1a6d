"""Configs of the built-in agents."""

import dataclasses
import json
import subprocess
import sys
from typing import Any

import pytest
import tyro

from mpma_mj.agents import (
    AGENTS,
    AdaptiveConfig,
    AgentConfig,
    HAMMERConfig,
    MOSAICConfig,
    MPMAConfig,
    OracleConfig,
    SingleConfig,
)
from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.agents.learning_rules import GatedRule
from mpma_mj.errors import BadOptionError

TYPES = {name: agent.config_type for name, agent in AGENTS.items()}


@pytest.mark.parametrize("config_type", TYPES.values())
def test_configs_are_equal_and_hashable_by_their_values_and_go_through_json(
    config_type: type[AgentConfig],
) -> None:
    config = config_type()
    assert config == config_type()
    assert hash(config) == hash(config_type())
    stored = json.loads(json.dumps(dataclasses.asdict(config)))
    assert config_type(**stored) == config


def test_each_agent_has_a_config_class_of_its_own() -> None:
    assert TYPES == CONFIG_TYPES
    assert len(set(TYPES.values())) == len(AGENTS)


def test_what_an_agent_does_not_have_is_not_among_its_fields() -> None:
    names = {kind: {field.name for field in dataclasses.fields(c)} for kind, c in TYPES.items()}
    assert "modules" not in names["single"] | names["hammer"]
    assert "ridge" not in names["mosaic"]
    assert "rule" not in names["mosaic"] | names["hammer"]
    assert "modules" not in names["adaptive"]
    assert "max_plants" not in names["single"] | names["mosaic"] | names["hammer"]
    assert names["oracle"] == names["mpma"]
    assert not names["random"] | names["open_loop"] | names["feedback_only"]
    assert not names["resolved_rate"]
    networks = {"nodes", "spectral_radius", "reservoir_noise", "context_signal"}
    paired = {"models", "history", "proprioception"}
    assert networks <= names["adaptive"]
    assert not paired & names["adaptive"]
    for kind in ("mpma", "single", "mosaic", "hammer", "oracle"):
        assert networks | paired <= names[kind]


@pytest.mark.parametrize("config_type", TYPES.values())
def test_the_command_line_shows_every_field_with_its_help(
    config_type: type[AgentConfig], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        tyro.cli(config_type, args=["--help"])
    shown = capsys.readouterr().out
    for field in dataclasses.fields(config_type):
        assert f"--{field.name.replace('_', '-')}" in shown
        assert f"{field.name}:" in str(
            [base.__doc__ for base in config_type.__mro__ if base.__doc__ is not None]
        )


def test_the_command_line_takes_the_path_of_a_rule() -> None:
    assert tyro.cli(MPMAConfig, args=["--rule", "mine.py:Rule"]) == MPMAConfig(rule="mine.py:Rule")


def test_configs_load_without_networks_or_simulation() -> None:
    code = (
        "import sys, mpma_mj.agents.config;"
        "print([m for m in ('scipy', 'mujoco', 'dm_env', 'mpma_mj.esn') if m in sys.modules])"
    )
    command = [sys.executable, "-c", code]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.parametrize(
    ("config_type", "options", "message"),
    [
        (MPMAConfig, {"modules": 0}, "modules is 0; expected a whole number from 1 to 1000"),
        (MPMAConfig, {"modules": True}, "modules is True"),
        (MPMAConfig, {"modules": 2.5}, "modules is 2.5; expected a whole"),
        (MPMAConfig, {"nodes": 0}, "nodes is 0"),
        (MPMAConfig, {"nodes": "x"}, "nodes is 'x'"),
        (MPMAConfig, {"rule": "magic"}, "rule is 'magic'; expected weighted, gated, or the path"),
        (MPMAConfig, {"rule": None}, "rule is None; expected .*, or an instance of LearningRule"),
        (MPMAConfig, {"rule": SingleConfig}, "rule is <class"),
        (MPMAConfig, {"efference_copy": "none"}, "efference_copy is 'none'; expected one of total"),
        (MPMAConfig, {"spectral_radius": 1.0}, "spectral_radius is 1"),
        (MPMAConfig, {"spectral_radius": "a"}, "spectral_radius is 'a'; expected 0 or more, below"),
        (MPMAConfig, {"spectral_radius": float("nan")}, "spectral_radius is nan"),
        (MPMAConfig, {"reservoir_noise": -0.1}, "reservoir_noise is -0.1"),
        (MPMAConfig, {"reservoir_noise": None}, "reservoir_noise is None"),
        (MPMAConfig, {"ridge": 0.0}, "ridge is 0.0; expected above 0"),
        (HAMMERConfig, {"ridge": "much"}, "ridge is 'much'"),
        (MPMAConfig, {"forward_gating": "no"}, "forward_gating is 'no'; expected True or False"),
        (MPMAConfig, {"responsibility_predictors": 0}, "responsibility_predictors is 0"),
        (SingleConfig, {"proprioception": None}, "proprioception is None"),
        (SingleConfig, {"context_signal": "noise"}, "context_signal is 'noise'; expected one of"),
        (MOSAICConfig, {"inverse_rate": 0.0}, "inverse_rate is 0.0; expected above 0, below 2"),
        (MOSAICConfig, {"forward_rate": 2.0}, "forward_rate is 2.0"),
        (MOSAICConfig, {"predictor_rate": "fast"}, "predictor_rate is 'fast'"),
        (MOSAICConfig, {"sigma": -1.0}, "sigma is -1.0; expected above 0"),
        (MPMAConfig, {"models": "both"}, "models is 'both'; expected one of joint, posture"),
        (MPMAConfig, {"max_plants": 0}, "max_plants is 0; expected a whole number from 1 to 100"),
        (MPMAConfig, {"novelty": 1.0}, "novelty is 1.0; expected above 1"),
        (MPMAConfig, {"temperature": 1.5}, "temperature is 1.5; expected 0 to 1"),
        (MPMAConfig, {"switching_probability": 0.0}, "switching_probability is 0.0; expected abov"),
        (MPMAConfig, {"switching_probability": 0.6}, "switching_probability is 0.6"),
        (MPMAConfig, {"inverse_ridge": 0.0}, "inverse_ridge is 0.0; expected above 0"),
        (MPMAConfig, {"history": 1}, "history is 1; expected True or False"),
        (AdaptiveConfig, {"forgetting": 1.0}, "forgetting is 1.0"),
        (AdaptiveConfig, {"inverse_ridge": -1.0}, "inverse_ridge is -1.0; expected above 0"),
    ],
)
def test_values_out_of_bounds_are_named(
    config_type: type[AgentConfig], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        config_type(**options)


POSTURE: dict[str, Any] = {"models": "posture", "rule": "gated"}


@pytest.mark.parametrize("config_type", [MPMAConfig, SingleConfig, OracleConfig])
@pytest.mark.parametrize(
    ("options", "option", "message"),
    [
        ({"rule": "gated"}, "rule", "expected a rule for joint models; .*choose models=posture"),
        (
            {"models": "posture"},
            "rule",
            "rule is 'weighted'; expected a rule for posture models; .*choose models=joint",
        ),
        ({"rule": GatedRule()}, "rule", "expected a rule for joint models"),
        (
            {"efference_copy": "module"},
            "efference_copy",
            "expected the default, as joint models do not use it; .* or choose models=posture",
        ),
        ({"proprioception": False}, "proprioception", "joint models do not use it"),
        (POSTURE | {"history": True}, "history", "posture models do not use it"),
        (POSTURE | {"inverse_ridge": 0.1}, "inverse_ridge", "or choose models=joint"),
        (POSTURE | {"temperature": 0.5}, "temperature", "posture models do not use it"),
        (POSTURE | {"max_plants": 2}, "max_plants", "posture models do not use it"),
        (POSTURE | {"novelty": 2.0}, "novelty", "posture models do not use it"),
        (POSTURE | {"switching_probability": 0.1}, "switching_probability", "do not use it"),
    ],
)
def test_options_that_do_not_fit_the_models_are_refused_in_one_line(
    config_type: type[SingleConfig], options: dict[str, Any], option: str, message: str
) -> None:
    if set(options) - {field.name for field in dataclasses.fields(config_type)}:
        pytest.skip("a single pair does not have this option at all")
    with pytest.raises(BadOptionError, match=message) as error:
        config_type(**options)
    assert error.value.option == option
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("config", "options", "message"),
    [
        (MOSAICConfig, {"proprioception": False}, "False; .*joint models do not use it"),
        (HAMMERConfig, {"proprioception": False}, "or choose models=posture"),
        (MOSAICConfig, {"models": "posture", "history": True}, "posture models do not use it"),
        (HAMMERConfig, {"models": "posture", "inverse_ridge": 0.1}, "or choose models=joint"),
    ],
)
def test_rivals_refuse_options_of_the_other_space_too(
    config: type[AgentConfig], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        config(**options)


def test_the_papers_models_need_both_options() -> None:
    config = MPMAConfig(**POSTURE, efference_copy="module", proprioception=False)
    assert (config.models, config.rule) == ("posture", "gated")
