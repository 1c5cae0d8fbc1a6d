"""Responsibility of posture models: prior and likelihood."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj.agents.gating import (
    balanced_preferences,
    likelihood,
    mixed_outputs,
    prediction_errors,
    responsibilities,
)
from mpma_mj.agents.learning_rules import GatedRule
from tests.agents.test_mpma import JOINT, POSTURE, agent, dance, signals_of, watch

priors = arrays(np.float64, 4, elements=st.floats(0.01, 1.0))
errors = arrays(np.float64, 4, elements=st.floats(0.0, 4.0))


@given(priors, errors, st.floats(0.02, 1.0))
def test_responsibilities_are_shares(prior: np.ndarray, error: np.ndarray, sigma: float) -> None:
    share = responsibilities(prior, likelihood(error, sigma))
    assert np.isclose(share.sum(), 1.0)
    assert (share >= 0).all()


@given(priors, errors, st.floats(0.1, 1.0), st.floats(0.0, 0.5))
def test_the_least_error_cancels(
    prior: np.ndarray, error: np.ndarray, sigma: float, offset: float
) -> None:
    # λ of the plain likelihoods exp(-err / 2σ²), wherever those do not vanish
    plain = np.exp(-(error + offset) / (2 * sigma**2))
    if plain.max() > 1e-200:
        expected = prior * plain / (prior * plain).sum()
        np.testing.assert_allclose(
            responsibilities(prior, likelihood(error, sigma)), expected, atol=1e-12
        )


def test_equal_errors_leave_the_prior() -> None:
    prior = np.array([0.2, 0.6, 0.1, 0.1])
    np.testing.assert_allclose(responsibilities(prior, likelihood(np.ones(4), 0.1)), prior)


def test_a_better_prediction_gains_responsibility() -> None:
    share = responsibilities(np.array([0.9, 0.1]), likelihood(np.array([1.0, 0.0]), 0.1))
    assert share[1] > 0.999


def test_hopeless_predictions_still_give_numbers() -> None:
    assert (likelihood(np.array([1e6, 2e6]), 0.02) == [1.0, 0.0]).all()


@given(st.integers(1, 5), st.integers(1, 4), st.integers(0, 99))
def test_outputs_are_mixed_by_responsibility_whatever_plants_other_runs_have(
    modules: int, plants: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    share, outputs = rng.random(plants * modules), rng.normal(size=(plants * modules, 8))
    mixed = mixed_outputs(share, outputs, modules)
    np.testing.assert_allclose(mixed, share @ outputs, atol=1e-12)
    more = np.zeros((3, 2 * plants * modules))
    more[1, : len(share)] = share
    wide = rng.normal(size=(*more.shape, 8))
    wide[1, : len(share)] = outputs
    np.testing.assert_array_equal(mixed_outputs(more, wide, modules)[1], mixed)


def test_prediction_error_is_the_mean_square() -> None:
    predictions = np.zeros((7, 3, 12))
    predictions[:, 1] = 0.5
    np.testing.assert_allclose(
        prediction_errors(predictions, np.zeros((7, 12))), np.tile([0, 0.25, 0], (7, 1))
    )


@pytest.mark.parametrize("config", [JOINT, POSTURE])
def test_without_forward_gating_responsibility_is_the_predictors_share(
    config: dict[str, Any],
) -> None:
    player = agent(forward_gating=False, **config)
    dance(player, 3)
    signals = signals_of(player)
    share = signals.prior / signals.prior.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(signals.responsibility, share, rtol=1e-14)
    assert share.std() > 0.01


def test_without_predictors_responsibility_is_the_likelihoods_share() -> None:
    player = agent(responsibility_predictors=False, **POSTURE)
    dance(player, 2)
    sigma = GatedRule.sigma
    postures = np.stack([seen["posture"] for seen in watch(player)])
    signals = signals_of(player)
    np.testing.assert_array_equal(signals.prior, 1.0)
    responsibility = signals.responsibility
    np.testing.assert_allclose(responsibility[0], 1 / 3, rtol=1e-14)
    errors = prediction_errors(signals.predictions[:-1], postures[1:-1])
    likely = likelihood(errors, sigma)
    np.testing.assert_allclose(responsibility[1:], likely / likely.sum(axis=1, keepdims=True))
    assert responsibility.std() > 1e-6


@pytest.mark.parametrize("config", [JOINT, POSTURE])
def test_without_both_responsibility_is_uniform(config: dict[str, Any]) -> None:
    player = agent(forward_gating=False, responsibility_predictors=False, **config)
    dance(player, 2)
    np.testing.assert_allclose(signals_of(player).responsibility, 1 / 3, rtol=1e-14)


shares_of_modules = st.integers(2, 4).flatmap(
    lambda m: arrays(np.float64, (2 * m, m), elements=st.floats(0.2, 1.0))
)


@given(shares_of_modules, st.floats(1.0, 3.0), st.integers(0, 99))
def test_balanced_preferences_are_shares_and_use_all_modules_alike(
    shares: np.ndarray, sharpening: float, seed: int
) -> None:
    visits = np.random.default_rng(seed).uniform(5.0, 20.0, len(shares))
    preferences = balanced_preferences(shares, visits, sharpening)
    np.testing.assert_allclose(preferences.sum(axis=1), 1.0)
    usage = visits @ preferences / visits.sum()
    np.testing.assert_allclose(usage * shares.shape[1], 1.0, atol=0.05)


@given(shares_of_modules, st.floats(1.0, 3.0))
def test_balancing_is_a_factor_for_each_module_and_one_for_each_label(
    shares: np.ndarray, sharpening: float
) -> None:
    preferences = balanced_preferences(shares, np.ones(len(shares)), sharpening)
    rest = np.log(preferences) - sharpening * np.log(shares)
    rest -= rest.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(rest, np.tile(rest[0], (len(rest), 1)), atol=1e-9)


def test_preferences_that_are_balanced_have_their_closed_form() -> None:
    shares = np.array([[0.6, 0.3, 0.1], [0.1, 0.6, 0.3], [0.3, 0.1, 0.6]])
    np.testing.assert_allclose(balanced_preferences(shares, np.ones(3), 1.0), shares)
    sharp = shares**2 / (0.6**2 + 0.3**2 + 0.1**2)
    np.testing.assert_allclose(balanced_preferences(shares, np.ones(3), 2.0), sharp)
    alike = balanced_preferences(np.tile([0.7, 0.3, 0.0], (9, 1)), np.ones(9), 3.0)
    np.testing.assert_allclose(alike, 1 / 3)  # also a module that was never used


def test_labels_count_by_their_visits() -> None:
    shares = np.array([[0.9, 0.1], [0.5, 0.5], [0.5, 0.5]])
    preferences = balanced_preferences(shares, np.array([2.0, 1.0, 1.0]), 1.0)
    np.testing.assert_allclose(np.array([2.0, 1.0, 1.0]) @ preferences, 2.0, rtol=1e-2)
    never = balanced_preferences(shares, np.array([0.0, 1.0, 1.0]), 1.0)
    np.testing.assert_allclose(never, shares, rtol=1e-6)
