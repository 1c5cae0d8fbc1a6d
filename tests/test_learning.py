"""That it learns: small networks quickly here, all seeds in the slow suite."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dm_control.rl import control

from mpma_mj import MPMAConfig, load, make_agent
from mpma_mj.agents import Agent, SingleConfig
from mpma_mj.context import equal_segments
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run import train
from mpma_mj.training.run_folder import RunFolder


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_the_dance_is_learned_by_several_modules(arms: str, tmp_path: Path) -> None:
    config = RunConfig.of(nodes=100, arms=arms)  # type: ignore[arg-type]
    summary = train(config, folder=RunFolder(tmp_path / "run")).summary
    assert summary["converged"]
    assert summary["p_e_percent"] < 1.0
    assert summary["feedback_ratio"] < 0.1
    assert summary["modules_used"] >= 3
    assert summary["repeatability"]["responsibility"] > 0.8


PAPER: dict[str, Any] = {"models": "posture", "rule": "gated", "nodes": 100}
TWO_PLANTS: dict[str, Any] = {
    "plants": [{}, {"actuator_gain": 0.5}],
    "epochs_per_plant": 3,
    "repeats": 1,
}


def errors(env: control.Environment, agent: Agent, epochs: int) -> list[float]:
    """Train an agent; return p_e by epoch."""
    found = []
    for epoch in range(epochs):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
        found.append(posture_error_percent(trace.posture, trace.reference))
    return found


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
@pytest.mark.parametrize("seed", [0, 1])
def test_joint_models_of_20_nodes_dance_in_the_third_epoch(arms: str, seed: int) -> None:
    env = load("ymca", arms=arms, seed=seed)
    agent = make_agent(env, MPMAConfig(nodes=20), seed=seed)
    by_epoch = errors(env, agent, 3)
    assert by_epoch[0] > 1.0
    assert by_epoch[2] < 0.3
    usual = errors(env, make_agent(env, kind="resolved_rate"), 1)[0]
    assert by_epoch[2] < 0.5 * usual


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_a_plant_that_is_left_is_not_forgotten(arms: str) -> None:
    env = load("ymca", arms=arms, **TWO_PLANTS)
    agent: Any = make_agent(env, MPMAConfig(nodes=20))
    by_epoch = errors(env, agent, 7)
    assert agent.state_dict()["plants.recruited"] == 2
    assert by_epoch[6] < 1.1 * by_epoch[2]  # back in the first plant, from the first epoch
    assert by_epoch[5] < 0.4
    # One pair with as many nodes as all modules of both plants.
    single = errors(env, make_agent(env, SingleConfig(nodes=160), kind="single"), 7)
    assert single[2] < 0.3
    assert by_epoch[6] < 0.5 * single[6]


def test_one_plant_stays_one() -> None:
    env = load("ymca", repeats=1)
    agent = make_agent(env, MPMAConfig(nodes=20))
    errors(env, agent, 10)
    assert agent.state_dict()["plants.recruited"] == 1


def test_the_papers_rule_converges(tmp_path: Path) -> None:
    summary = train(RunConfig.of(**PAPER), folder=RunFolder(tmp_path / "run")).summary
    assert summary["converged"]
    assert summary["p_e_percent"] < 3.0
    assert all(1 <= count <= 3 for count in summary["active_modules"].values())


def test_one_module_dances_too(tmp_path: Path) -> None:
    summary = train(RunConfig.of(nodes=100, modules=1), folder=RunFolder(tmp_path / "run")).summary
    assert summary["converged"]
    assert summary["nmi"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.2])
def test_arms_that_swing_past_straight_forward_are_learned(offset: float) -> None:
    swing = np.pi / 2 + 1.4 * np.sin(np.linspace(0, 4 * np.pi, 100, endpoint=False))
    upper_arm = np.stack([np.sin(swing), np.full(100, offset), -np.cos(swing)], axis=1)
    posture = np.concatenate([upper_arm, upper_arm, *[upper_arm * [1, -1, 1]] * 2], axis=1)
    posture /= np.sqrt(1 + offset**2)
    context, labels = equal_segments(100, 4)
    motion = Motion(posture, context, labels, 20.0, "swing", "a test")
    assert train(RunConfig.of(nodes=100), 20, motion=motion).summary["converged"]


def test_arms_raised_through_straight_forward_and_lowered_sideways_are_learned() -> None:
    # The shoulder comes back turned over: abduction and rotation by half a turn, flexion by one.
    way = np.array([[0.1, 0.02, -1], [1, 0.05, 0], [0.1, 0.1, 1], [0.05, 1, 0], [0.1, 0.02, -1]])
    knots = way / np.linalg.norm(way, axis=1, keepdims=True)
    share = (1 - np.cos(np.pi * np.arange(24) / 24))[:, None] / 2
    upper_arm = np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(knots)])
    upper_arm /= np.linalg.norm(upper_arm, axis=1, keepdims=True)
    forearm = upper_arm + np.array([0.45, 0.25, 0.55])
    forearm /= np.linalg.norm(forearm, axis=1, keepdims=True)
    left = np.concatenate([upper_arm, forearm], axis=1)
    posture = np.concatenate([left, left * [1, -1, 1, 1, -1, 1]], axis=1)
    context, labels = equal_segments(len(posture), 4)
    motion = Motion(posture, context, labels, 20.0, "raise", "a test")

    def best(**options: Any) -> float:
        summary = train(RunConfig.of(**options), 20, motion=motion).summary
        return summary["p_e_percent"] if summary["converged"] else np.inf

    assert best() < 1.5
    sensing = best(**PAPER)
    assert sensing < 3.0
    assert best(**PAPER, proprioception=False) > sensing


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_every_seed_converges(seed: int, tmp_path: Path) -> None:
    summary = train(RunConfig.of(seed=seed), folder=RunFolder(tmp_path / "weighted")).summary
    assert summary["converged"]
    assert summary["epochs"] <= 9
    assert summary["p_e_percent"] < 0.8
    gated = RunConfig.of(seed=seed, **PAPER)
    assert train(gated, folder=RunFolder(tmp_path / "gated")).summary["p_e_percent"] < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("motion", ["wave", "conductor", "semaphore:HELLO"])
def test_dances_made_by_hand_are_learned_with_default_options(motion: str, seed: int) -> None:
    summary = train(RunConfig.of(motion, seed=seed)).summary
    assert summary["converged"]
    assert summary["p_e_percent"] < 0.3
