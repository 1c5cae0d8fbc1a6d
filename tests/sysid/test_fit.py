"""The parts of a fit: replays, derivatives, intervals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.envs.model import make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import DivergedError
from mpma_mj.sysid import RobotLog, record
from mpma_mj.sysid.fit import robust_loss
from mpma_mj.sysid.misfit import Misfit
from mpma_mj.sysid.parameters import UNITS, changed
from mpma_mj.sysid.simulate import FeatureReplay, threads
from mpma_mj.sysid.uncertainty import Evidence, evidence
from tests.sysid.conftest import LATENCY

MODEL = make_model(EnvironmentOptions())
NAMES = list(UNITS)
REFERENCE = NAMES.index("forearm_mass")


@pytest.fixture(scope="module")
def gentle() -> RobotLog:
    """Return a log of the model's own arms in which no actuator reaches its greatest force."""
    env = mpma_mj.load("ymca", repeats=20)
    rng = np.random.default_rng(0)
    turn, phase = rng.uniform(1.0, 12.0, 8), rng.uniform(0.0, 6.0, 8)
    moments = iter(range(1000))

    def act(observation: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        towards = np.array([0.5, 0.3, 0.0, 1.4] * 2) - observation["joint_angles"]
        action: NDArray[np.float64] = 0.05 * np.sin(turn * 0.05 * next(moments) + phase)
        return action + 0.05 * np.tanh(towards)

    log = record(env, act, 6.0)
    force = np.abs(20.0 * (log.command - log.velocity))[20:]
    assert force.max() < 40.0  # N m, the least of the greatest forces
    return dataclasses.replace(
        log, **{name: getattr(log, name)[20:] for name in ("time", "command", "angle", "velocity")}
    )


def misfit_of(log: RobotLog, pool: object, factors: dict[str, float] | None = None) -> Misfit:
    model = changed(MODEL, factors or {})
    begins = np.arange(6, len(log) - 5, 5)
    return Misfit(model, FeatureReplay(pool, MODEL, log, begins, length=5, steps=10), NAMES)


def evidence_at_truth(
    log: RobotLog, factors: dict[str, float] | None = None, latency: int = 0
) -> Evidence:
    """Return what a log without noise says, were it known to 0.001 rad."""
    with threads() as pool:
        return evidence(misfit_of(log, pool, factors), np.zeros(len(NAMES)), latency, 1e-3)


def test_gentle_commands_show_ratios_but_not_their_common_scale(gentle: RobotLog) -> None:
    said = evidence_at_truth(gentle)
    assert (said.half_widths() > 1.0).all()
    kv = [NAMES.index(name) for name in NAMES if name.startswith("kv")]
    ratios = said.half_widths_over(REFERENCE)
    assert (ratios[kv] < 0.05).all()
    assert ratios[REFERENCE] == 0.0


def test_a_dance_that_reaches_the_greatest_forces_shows_the_scale_too(
    log: RobotLog, factors: dict[str, float]
) -> None:
    assert (evidence_at_truth(log, factors, 10 * LATENCY).half_widths() < 0.01).all()


def test_a_parameter_of_which_the_log_says_nothing_has_no_end() -> None:
    said = Evidence(np.diag([0.0, 4.0, 1.0]), np.diag([0.0, 4.0, 1.0]))
    assert said.half_widths() == pytest.approx([np.inf, 0.98, 1.96])
    assert said.half_widths_over(2) == pytest.approx([np.inf, 0.98, 0.0])


def test_intervals_are_those_of_linear_regression() -> None:
    # Where the middle is the curvature, the covariance is its inverse.
    curvature = np.array([[4.0, 1.0], [1.0, 2.0]])
    said = Evidence(curvature, curvature)
    assert said.covariance() == pytest.approx(np.linalg.inv(curvature))
    assert said.half_widths_over(0) == pytest.approx([0.0, 1.96 / np.sqrt(2.0)])


def test_derivatives_are_those_of_central_differences(gentle: RobotLog) -> None:
    logs = np.linspace(-0.1, 0.1, len(NAMES))
    with threads() as pool:
        misfit = misfit_of(gentle, pool)
        jacobian = misfit.jacobian(logs, 3)
        for column, step in enumerate(1e-3 * np.eye(len(NAMES))):
            both = misfit.residual(logs + step, 3) - misfit.residual(logs - step, 3)
            assert np.allclose(jacobian[:, column], both.ravel() / 2e-3, atol=2e-4)


def test_no_derivative_is_taken_across_a_jump(log: RobotLog, factors: dict[str, float]) -> None:
    logs = np.array([np.log(factors[name]) + 0.01 for name in NAMES])
    with threads() as pool:
        misfit = misfit_of(log, pool)
        jacobian = misfit.jacobian(logs, 10 * LATENCY)
        step = 1e-4 * np.eye(len(NAMES))[0]
        across = misfit.residual(logs + step, 20) - misfit.residual(logs, 20)
    assert np.abs(jacobian).max() < 10.0
    assert (np.abs(jacobian[:, 0]) <= np.abs(across.ravel()) / 1e-4 + 1e-9).all()


def test_the_residual_of_a_log_of_the_model_itself_is_nothing(gentle: RobotLog) -> None:
    with threads() as pool:
        assert np.abs(misfit_of(gentle, pool).residual(np.zeros(len(NAMES)), 0)).max() < 1e-9


def test_the_loss_is_square_near_zero_and_grows_like_the_size_far_off() -> None:
    assert robust_loss(np.array([1e-3]), 1.0) == pytest.approx(1e-6, rel=1e-3)
    assert robust_loss(np.array([1e6]), 1.0) == pytest.approx(2e6, rel=1e-3)


def test_a_simulation_that_runs_away_is_told_with_its_row(gentle: RobotLog) -> None:
    wild = gentle.velocity.copy()
    wild[16] = 1e12
    with (
        threads() as pool,
        pytest.raises(DivergedError, match="run away where they begin as in row 18 of the log"),
    ):
        misfit_of(dataclasses.replace(gentle, velocity=wild), pool).residual(np.zeros(11), 0)
