"""A robot that differs from the model, and a log of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mpma_mj
from mpma_mj.sysid import RobotLog, record, write_model
from mpma_mj.sysid.parameters import UNITS

LATENCY = 2  # control steps


def perturbed(seed: int) -> dict[str, float]:
    """Return a factor on each parameter, up to 30 % off."""
    rng = np.random.default_rng(seed)
    return {name: float(rng.uniform(0.7, 1.3)) for name in UNITS}


def dance_of(model: Path, seconds: float, *, latency: int, noise: float = 0.0) -> RobotLog:
    """Return the log of arms of a model that dance YMCA by feedback."""
    env = mpma_mj.load(
        "ymca", model=model, latency=latency, repeats=20, observation_noise=noise, seed=0
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
