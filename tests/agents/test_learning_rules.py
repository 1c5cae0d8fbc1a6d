"""Learning rules: targets and weights of each readout, compared with the equations."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from mpma_mj.agents.learning_rules import Epoch, GatedRule, Readouts, WeightedRule

T, M = 40, 3


class Spy:
    """Records what a readout bank is fitted to."""

    def fit(self, features: np.ndarray, targets: np.ndarray, weights: Any = None) -> None:
        self.features, self.targets, self.weights = features, targets, weights


@pytest.fixture
def epoch() -> Epoch:
    rng = np.random.default_rng(0)
    shapes = {
        "inverse_features": (T, M, 5),
        "forward_features": (T, M, 6),
        "predictor_features": (T, M, 7),
        "context": (T, 4),
        "prior": (T, M),
        "responsibility": (T, M),
        "module_actions": (T, M, 8),
        "predictions": (T, M, 12),
        "action": (T, 8),
        "next_posture": (T, 12),
        "feedback": (T, 8),
        "next_feedback": (T, 8),
    }
    arrays = {name: rng.uniform(-1, 1, shape) for name, shape in shapes.items()}
    share = rng.uniform(0.1, 1, (T, M))
    arrays["responsibility"] = share / share.sum(axis=1, keepdims=True)
    return Epoch(**arrays, feedback_gain=0.3)


def fitted(rule: WeightedRule | GatedRule, epoch: Epoch) -> tuple[Spy, Spy, Spy]:
    spies = Spy(), Spy(), Spy()
    rule.fit(Readouts(*spies), epoch)  # type: ignore[arg-type]
    inverse, forward, predictor = spies
    assert inverse.features is epoch.inverse_features
    assert forward.features is epoch.forward_features
    assert predictor.features is epoch.predictor_features
    return inverse, forward, predictor


def each(targets: np.ndarray) -> np.ndarray:
    """Return targets for every module, shape (T, M, K)."""
    return np.broadcast_to(targets, (T, M, targets.shape[2]))


def test_weighted_forward_models_learn_the_next_posture_weighted_by_responsibility(
    epoch: Epoch,
) -> None:
    _, forward, _ = fitted(WeightedRule(), epoch)
    np.testing.assert_array_equal(each(forward.targets)[:, 1], epoch.next_posture)
    np.testing.assert_array_equal(forward.weights, epoch.responsibility)


def test_weighted_inverse_models_learn_the_desired_command(epoch: Epoch) -> None:
    inverse, _, _ = fitted(WeightedRule(), epoch)
    hit = np.clip(epoch.action + epoch.next_feedback, -1, 1)
    assert np.abs(epoch.action + epoch.next_feedback).max() > 1
    np.testing.assert_array_equal(each(inverse.targets)[:, 2], hit)
    np.testing.assert_array_equal(inverse.weights, epoch.responsibility)


def test_weighted_predictors_learn_sharpened_and_balanced_responsibility(epoch: Epoch) -> None:
    _, _, predictor = fitted(WeightedRule(), epoch)
    target = predictor.targets[:, :, 0]
    np.testing.assert_allclose(target.sum(axis=1), 1.0)
    # log y = 3 log λ + what a step has for all modules + what a module has for all steps
    rest = np.log(target) - 3.0 * np.log(epoch.responsibility)
    rest -= rest.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(rest, np.tile(rest[0], (len(rest), 1)), atol=1e-12)
    assert predictor.weights is None


def test_weighted_sigma_is_the_responsible_modules_rms_error(epoch: Epoch) -> None:
    square = np.mean((epoch.predictions - epoch.next_posture[:, None]) ** 2, axis=2)
    expected = np.sqrt(np.mean(np.sum(epoch.responsibility * square, axis=1)))
    assert WeightedRule().next_sigma(epoch, 9.0) == pytest.approx(expected)
    perfect = np.repeat(epoch.next_posture[:, None], M, axis=1)
    exact = dataclasses.replace(epoch, predictions=perfect)
    assert WeightedRule().next_sigma(exact, 9.0) == WeightedRule().least_sigma


def test_gated_errors_are_multiplied_by_responsibility(epoch: Epoch) -> None:
    inverse, forward, predictor = fitted(GatedRule(), epoch)
    for i in range(M):
        gate = epoch.responsibility[:, i, None]
        came = epoch.predictions[:, i]
        np.testing.assert_allclose(
            forward.targets[:, i], came + gate * (epoch.next_posture - came), rtol=1e-12
        )
        np.testing.assert_allclose(
            inverse.targets[:, i],
            epoch.module_actions[:, i] + 0.2 * gate * 0.3 * epoch.next_feedback,
            rtol=1e-12,
        )
    np.testing.assert_array_equal(predictor.targets[:, :, 0], epoch.responsibility)
    assert inverse.weights is forward.weights is predictor.weights is None


def test_gated_sigma_stays(epoch: Epoch) -> None:
    assert GatedRule().next_sigma(epoch, 0.144) == 0.144


def test_only_the_weighted_rule_has_memory() -> None:
    assert GatedRule().forgetting == 0.0
    assert 0.0 < WeightedRule().forgetting < 1.0
