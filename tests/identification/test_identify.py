"""That parameters are found again, and what a log does not show is told."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mpma_mj
from mpma_mj.cli import main
from mpma_mj.envs.model import MODEL_PATH, make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import DivergedError
from mpma_mj.identification import Identified, RobotLog, identify, record, write_log
from mpma_mj.identification.misfit import Misfit
from mpma_mj.identification.parameters import UNITS
from mpma_mj.identification.simulate import Replay, threads
from mpma_mj.identification.table import as_markdown
from tests.identification.conftest import LATENCY, dance_of, perturbed


@pytest.fixture(scope="module")
def found(log: RobotLog) -> Identified:
    return identify(log)


def test_perturbed_parameters_are_found_within_a_percent(
    found: Identified, factors: dict[str, float]
) -> None:
    assert max(abs(factor - 1.0) for factor in factors.values()) > 0.2
    assert set(found.factors) == set(UNITS)
    for one in found.estimates:
        assert one.factor == pytest.approx(factors[one.name], rel=0.01), one.name
        assert one.determined
    assert found.latency.steps == 10 * LATENCY
    assert found.latency.control_steps == LATENCY
    assert found.latency.is_whole
    low, high = found.latency.interval
    assert low < 10 * LATENCY < high


def test_with_what_was_found_the_simulation_does_what_the_log_shows(found: Identified) -> None:
    assert found.rms_of_all(found.before) > 0.1
    assert found.rms_of_all(found.after) < 0.01


def test_the_command_leaves_a_model_that_dances_like_the_robot(
    log: RobotLog, factors: dict[str, float], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_log(tmp_path / "log.csv", log)
    out = tmp_path / "found"
    assert main(["identify", str(tmp_path / "log.csv"), "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert printed.err == "simulating the log with other parameters\n"
    lines = printed.out.splitlines()
    assert lines[0] == "| parameter | unit | in the model | found | 95 % interval | remark |"
    assert lines[2].startswith("| kv_shoulder_abduction | N m s/rad | 20 | ")
    assert "| latency | ms | 0 | 100 | 97.5 to 102.5 | 2 × the control step of 50 ms |" in lines
    assert lines[-2].startswith("RMS error of the angles over windows of 1 s: ")
    assert lines[-1] == str(out)
    content = json.loads((out / "identified.json").read_text())
    assert content["latency"]["control_steps"] == LATENCY
    for name, told in content["parameters"].items():
        assert told["factor"] == pytest.approx(factors[name], rel=0.01)
        assert told["determined"]
    assert (out / "identified.png").read_bytes().startswith(b"\x89PNG")
    model = out / "identified.xml"
    env = mpma_mj.load("ymca", model=model, latency=LATENCY, repeats=20, seed=0)
    agent = mpma_mj.make_agent(env, kind="feedback_only")
    agent.reset(0)
    again = record(env, agent.act, 2.0)
    assert np.abs(again.angle - log.angle[: len(again)]).max() < 0.02
