"""That parameters are found again from noisy logs, and with arms of one's own."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.envs.model import MODEL_PATH
from mpma_mj.sysid import identify, record, write_model
from tests.sysid.conftest import LATENCY, dance_of, perturbed


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "off"), [(0.001, 0.05), (0.005, 0.15)])
def test_noise_leaves_parameters_near(noise: float, off: float, tmp_path: Path) -> None:
    inside = []
    for seed in range(2):
        true = perturbed(seed)
        write_model(tmp_path / "robot.xml", true)
        log = dance_of(tmp_path / "robot.xml", 20.0, latency=LATENCY, noise=noise)
        found = identify(log)
        assert found.latency.steps == 10 * LATENCY
        for one in found.estimates:
            assert one.factor == pytest.approx(true[one.name], rel=off), one.name
            assert one.determined
            low, high = one.interval
            inside.append(low <= true[one.name] <= high)
    assert np.mean(inside) >= 0.6  # of intervals that should hold 95 %; docs/identify.md


@pytest.mark.slow
def test_what_is_0_in_ones_own_model_is_told_and_the_rest_found(tmp_path: Path) -> None:
    own, robot = tmp_path / "own.xml", tmp_path / "robot.xml"
    own.write_text(MODEL_PATH.read_text().replace('damping="0.3"', 'damping="0"'))
    write_model(robot, {"kv_elbow": 1.2}, own)
    found = identify(dance_of(robot, 6.0, latency=0), model=own)
    assert len(found.missing) == 4
    assert all(name.startswith("damping_") for name in found.missing)
    assert found.factors.keys().isdisjoint(found.missing)
    assert found.factors["kv_elbow"] == pytest.approx(1.2, rel=0.01)
    assert found.latency.steps == 0


@pytest.mark.slow
def test_arms_whose_weight_is_carried_are_told_from_those_that_sink(tmp_path: Path) -> None:
    robot = tmp_path / "robot.xml"
    write_model(robot, {"forearm_mass": 1.2})
    env = mpma_mj.load("ymca", model=robot, repeats=20, gravity_compensation=True)
    agent = mpma_mj.make_agent(env, kind="feedback_only")
    agent.reset(0)
    log = record(env, agent.act, 6.0)
    carried, sinking = identify(log, gravity_compensation=True), identify(log)
    assert carried.factors["forearm_mass"] == pytest.approx(1.2, rel=0.01)
    assert carried.rms_of_all(carried.after) < 0.1 * sinking.rms_of_all(sinking.after)


@pytest.mark.slow
def test_gentle_commands_find_ratios_at_the_models_own_scale(tmp_path: Path) -> None:
    robot = tmp_path / "robot.xml"
    write_model(robot, {"kv_elbow": 0.9} | {"forearm_mass": 1.2})
    env = mpma_mj.load("ymca", model=robot, repeats=20)
    rng = np.random.default_rng(0)
    turn, phase = rng.uniform(1.0, 12.0, 8), rng.uniform(0.0, 6.0, 8)
    moments = iter(range(1000))

    def act(observation: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        towards = np.array([0.5, 0.3, 0.0, 1.4] * 2) - observation["joint_angles"]
        swing = np.sin(turn * 0.05 * next(moments) + phase)
        return np.asarray(0.05 * swing + 0.05 * np.tanh(towards))

    log = record(env, act, 8.0)
    parts = {name: getattr(log, name)[20:] for name in ("time", "command", "angle", "velocity")}
    found = identify(dataclasses.replace(log, **parts))
    assert found.scale_is_open
    assert found.factors["forearm_mass"] == 1.0
    assert found.factors["kv_elbow"] == pytest.approx(0.9 / 1.2, rel=0.05)
    assert not any(one.determined for one in found.estimates)
