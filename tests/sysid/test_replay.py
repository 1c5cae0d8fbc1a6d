"""Simulation of a log's commands."""

import dataclasses

import numpy as np
import pytest

from mpma_mj.envs.model import make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import DivergedError
from mpma_mj.sysid import RobotLog
from mpma_mj.sysid.parameters import UNITS, scaled
from tests.sysid.conftest import LATENCY, replay_of

MODEL = make_model(EnvironmentOptions())


def test_the_true_parameters_replay_a_log_exactly(log: RobotLog, factors: dict[str, float]) -> None:
    true = scaled(MODEL, factors)
    with replay_of(log, [10, 30], 20) as replay:
        exact = replay.simulate(true, 10 * LATENCY)
        assert np.abs(exact - replay.logged).max() < 1e-3  # numbers on file have six digits
        assert np.abs(replay.residual(true, 10 * LATENCY)).max() < 1e-4
        late = replay.simulate(true, 10 * LATENCY + 1)
        assert np.abs(late - replay.logged)[..., :8].max() > 0.01


def test_a_latency_of_half_a_step_lies_between_whole_ones(gentle: RobotLog) -> None:
    with replay_of(gentle, [10, 30], 10) as replay:
        early, between, late = (replay.simulate(MODEL, steps) for steps in (2.0, 2.5, 3.0))
        assert np.allclose(replay.simulate(MODEL, 2.0 + 1e-12), early, atol=1e-9)
    assert np.abs(late - early).max() > 0.01
    assert np.abs(between - 0.5 * (early + late)).max() < 0.01 * np.abs(late - early).max()


def test_a_common_factor_on_all_parameters_and_forces_changes_no_movement(log: RobotLog) -> None:
    # So a log in which no actuator reaches its greatest force does not show the common factor.
    double = scaled(MODEL, dict.fromkeys(UNITS, 2.0))
    with replay_of(log, [10], 40) as replay:
        weak = replay.simulate(double, 0)
        double.actuator_forcerange *= 2.0
        strong = replay.simulate(double, 0)
        plain = replay.simulate(MODEL, 0)
    assert np.abs(strong - plain)[..., :8].max() < 1e-9
    assert np.abs(weak - plain)[..., :8].max() > 0.1  # forces are reached here


def test_the_residual_of_a_log_of_the_model_itself_is_nothing(gentle: RobotLog) -> None:
    with replay_of(gentle, range(6, len(gentle) - 5, 5), 5) as replay:
        assert np.abs(replay.residual(MODEL, 0)).max() < 1e-9


def test_an_angle_that_is_off_at_the_start_of_a_window_counts_for_nothing(
    gentle: RobotLog,
) -> None:
    shifted = dataclasses.replace(gentle, angle=gentle.angle + 1e-4)
    with replay_of(shifted, [10], 5) as replay:
        assert np.abs(replay.residual(MODEL, 0)).max() < 2e-5


def test_a_simulation_that_runs_away_is_told_with_its_row(gentle: RobotLog) -> None:
    wild = gentle.velocity.copy()
    wild[16] = 1e12
    with (
        replay_of(dataclasses.replace(gentle, velocity=wild), [6, 11, 16], 5) as replay,
        pytest.raises(DivergedError, match="diverge from the state in row 18 of the log"),
    ):
        replay.simulate(MODEL, 0)
