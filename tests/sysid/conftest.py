"""A robot that differs from the model, and a log of it."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from mujoco import rollout
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.envs.model import make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.sysid import RobotLog, record, write_model
from mpma_mj.sysid.parameters import UNITS
from mpma_mj.sysid.replay import Replay

LATENCY = 2  # control steps


def perturbed(seed: int) -> dict[str, float]:
    """Return a factor on each parameter, up to 30 % off."""
    rng = np.random.default_rng(seed)
    return {name: float(rng.uniform(0.7, 1.3)) for name in UNITS}


def dance_of(model: Path | str, seconds: float, *, latency: int, noise: float = 0.0) -> RobotLog:
    """Return the log of arms of a model that dance YMCA by feedback."""
    env = mpma_mj.load(
        "ymca", robot=model, latency=latency, repeats=20, observation_noise=noise, seed=0
    )
    agent = mpma_mj.make_agent(env, kind="feedback_only")
    agent.reset(0)
    return record(env, agent.act, seconds)


@pytest.fixture(scope="session")
def factors() -> dict[str, float]:
    """Return how the robot differs from the model."""
    return perturbed(0)


@pytest.fixture(scope="session")
def log(factors: dict[str, float], tmp_path_factory: pytest.TempPathFactory) -> RobotLog:
    """Return a log of the robot, 6 s without noise."""
    model = tmp_path_factory.mktemp("robot") / "robot.xml"
    write_model(model, factors)
    return dance_of(model, 6.0, latency=LATENCY)


def gentle_log(model: Path | str, seconds: float) -> RobotLog:
    """Return a log in which no actuator reaches its greatest force, without the first second."""
    env = mpma_mj.load("ymca", robot=model, repeats=20)
    rng = np.random.default_rng(0)
    turn, phase = rng.uniform(1.0, 12.0, 8), rng.uniform(0.0, 6.0, 8)
    moments = iter(range(1000))

    def act(observation: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        towards = np.array([0.5, 0.3, 0.0, 1.4] * 2) - observation["joint_angles"]
        swing = np.sin(turn * 0.05 * next(moments) + phase)
        return np.asarray(0.05 * swing + 0.05 * np.tanh(towards))

    log = record(env, act, seconds)
    parts = {name: getattr(log, name)[20:] for name in ("time", "command", "angle", "velocity")}
    return dataclasses.replace(log, **parts)


@pytest.fixture(scope="session")
def gentle() -> RobotLog:
    """Return a log of the model's own arms in which no actuator reaches its greatest force."""
    log = gentle_log("two_arm", 6.0)
    assert np.abs(20.0 * (log.command - log.velocity)).max() < 40.0  # N m, the least of these
    return log


@contextlib.contextmanager
def replay_of(log: RobotLog, starts: Iterable[int], length: int) -> Iterator[Replay]:
    """Give windows of a log, of the package's arms."""
    with rollout.Rollout(nthread=1) as pool:
        model = make_model(EnvironmentOptions())
        yield Replay(pool, model, log, np.array([*starts]), length, 10)
