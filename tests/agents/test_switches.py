"""What can be switched off in MPMA, to see what it is good for."""

import numpy as np
import pytest

from mpma_mj.agents.gating import likelihood, prediction_errors
from tests.agents.test_mpma import agent, dance, signals_of, watch


@pytest.mark.parametrize("rule", ["weighted", "gated"])
def test_without_forward_gating_responsibility_is_the_predictors_share(rule: str) -> None:
    player = agent(rule=rule, forward_gating=False)
    dance(player, 3)
    signals = signals_of(player)
    share = signals.prior / signals.prior.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(signals.responsibility, share, rtol=1e-14)
    assert share.std() > 0.01


@pytest.mark.parametrize("rule", ["weighted", "gated"])
def test_without_predictors_all_are_as_suited_until_something_was_predicted(rule: str) -> None:
    player = agent(rule=rule, responsibility_predictors=False)
    dance(player, 2)
    sigma = float(player.state_dict()["sigma"])
    postures = np.stack([seen["posture"] for seen in watch(player)])
    signals = signals_of(player)
    np.testing.assert_array_equal(signals.prior, 1.0)
    responsibility = signals.responsibility
    np.testing.assert_allclose(responsibility[0], 1 / 3, rtol=1e-14)
    errors = prediction_errors(signals.predictions[:-1], postures[1:-1])
    likely = likelihood(errors, sigma)
    np.testing.assert_allclose(responsibility[1:], likely / likely.sum(axis=1, keepdims=True))
    assert responsibility.std() > 1e-6


def test_without_both_all_share_alike() -> None:
    player = agent(forward_gating=False, responsibility_predictors=False)
    dance(player, 2)
    np.testing.assert_allclose(signals_of(player).responsibility, 1 / 3, rtol=1e-14)
