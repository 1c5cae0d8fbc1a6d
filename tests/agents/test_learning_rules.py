"""Learning rules: targets and weights of each readout, compared with the equations."""

from typing import Any

import numpy as np
import pytest

from mpma_mj.agents.learning_rules import (
    Epoch,
    GatedRule,
    Readouts,
    WeightedRule,
    desired_command,
)

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
        "state": (T, 9),
        "prior": (T, M),
        "responsibility": (T, M),
        "module_actions": (T, M, 8),
        "predictions": (T, M, 12),
        "action": (T, 8),
        "outcome": (T, 12),
        "feedback": (T, 8),
        "next_feedback": (T, 8),
        "desired": (T, 8),
    }
    arrays = {name: rng.uniform(-1, 1, shape) for name, shape in shapes.items()}
    share = rng.uniform(0.1, 1, (T, M))
    arrays["responsibility"] = share / share.sum(axis=1, keepdims=True)
    assigned, usable = rng.uniform(0, 1, (T, M)), rng.random(T) < 0.7
    return Epoch(**arrays, feedback_gain=0.3, assignment=assigned, usable=usable)


def fitted(rule: WeightedRule | GatedRule, epoch: Epoch) -> tuple[Spy, Spy, Spy]:
    spies = Spy(), Spy(), Spy()
    rule.fit(Readouts(*spies), epoch)  # type: ignore[arg-type]
    inverse, forward, _ = spies
    assert inverse.features is epoch.inverse_features
    assert forward.features is epoch.forward_features
    return spies


def each(targets: np.ndarray) -> np.ndarray:
    """Return targets for every module, shape (T, M, K)."""
    return np.broadcast_to(targets, (T, M, targets.shape[2]))


def test_weighted_forward_models_learn_the_outcome_of_the_steps_assigned_to_them(
    epoch: Epoch,
) -> None:
    _, forward, _ = fitted(WeightedRule(), epoch)
    np.testing.assert_array_equal(each(forward.targets)[:, 1], epoch.outcome)
    np.testing.assert_array_equal(forward.weights, epoch.assignment)


def test_weighted_inverse_models_learn_what_they_should_have_returned_where_it_is_usable(
    epoch: Epoch,
) -> None:
    inverse, _, _ = fitted(WeightedRule(), epoch)
    np.testing.assert_array_equal(each(inverse.targets)[:, 2], epoch.desired)
    np.testing.assert_array_equal(inverse.weights[epoch.usable], epoch.assignment[epoch.usable])
    assert not inverse.weights[~epoch.usable].any()


def test_weighted_predictors_are_left_to_the_gate(epoch: Epoch) -> None:
    _, _, predictor = fitted(WeightedRule(), epoch)
    assert not vars(predictor)


def test_the_desired_command_is_bounded(epoch: Epoch) -> None:
    desired = desired_command(epoch.action, epoch.next_feedback)
    total = epoch.action + epoch.next_feedback
    assert np.abs(total).max() > 1
    np.testing.assert_array_equal(desired, np.clip(total, -1, 1))


def test_gated_errors_are_multiplied_by_responsibility(epoch: Epoch) -> None:
    inverse, forward, predictor = fitted(GatedRule(), epoch)
    assert predictor.features is epoch.predictor_features
    for i in range(M):
        gate = epoch.responsibility[:, i, None]
        came = epoch.predictions[:, i]
        np.testing.assert_allclose(
            forward.targets[:, i], came + gate * (epoch.outcome - came), rtol=1e-12
        )
        np.testing.assert_allclose(
            inverse.targets[:, i],
            epoch.module_actions[:, i] + 0.2 * gate * 0.3 * epoch.next_feedback,
            rtol=1e-12,
        )
    np.testing.assert_array_equal(predictor.targets[:, :, 0], epoch.responsibility)
    assert inverse.weights is forward.weights is predictor.weights is None


def test_only_the_weighted_rule_has_memory() -> None:
    assert GatedRule().forgetting == 0.0
    assert WeightedRule().forgetting == 1.0


def test_each_rule_says_which_models_it_is_made_for() -> None:
    assert (GatedRule().models, WeightedRule().models) == ("posture", "joint")
