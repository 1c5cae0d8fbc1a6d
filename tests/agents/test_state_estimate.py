"""State estimate: exact predictions, noise of a known size, innovations far off."""

import numpy as np

from mpma_mj.agents.state_models import StateEstimate

Array = np.ndarray


def gains(estimate: StateEstimate, observed: Array, predicted: Array) -> Array:
    """Return κ of each step, shape (T, ...), from the estimates of angles and velocities."""
    found = []
    for angles, ahead in zip(observed, predicted, strict=True):
        estimate.predict(ahead, np.zeros_like(ahead))
        _, speed = estimate(angles, np.ones_like(angles))  # κ 1 + (1 - κ) 0
        found.append(speed)
    return np.array(found)


def learned(shape: tuple[int, ...] = (), error: float = 1e-6) -> StateEstimate:
    estimate = StateEstimate(shape)
    for run in np.ndindex(shape):
        estimate.learn(np.full(8, error), run)
    return estimate


def test_the_first_state_of_an_episode_is_observed() -> None:
    rng = np.random.default_rng(0)
    estimate = learned()
    for _ in range(2):
        angles, speed = rng.normal(size=(2, 8))
        found = estimate(angles, speed)
        np.testing.assert_array_equal(found, (angles, speed))
        estimate.predict(angles + 1.0, speed)
        estimate.reset()


def test_without_noise_and_with_exact_predictions_the_estimate_is_the_observation() -> None:
    rng = np.random.default_rng(0)
    estimate = learned()
    path = rng.normal(size=(200, 8)).cumsum(axis=0)
    found = gains(estimate, path, path)
    np.testing.assert_allclose(found[1:], 1.0)
    for angles in path:
        estimate.predict(angles, np.zeros(8))
        np.testing.assert_array_equal(estimate(angles, np.zeros(8))[0], angles)


def test_errors_as_large_as_the_models_are_followed() -> None:
    rng = np.random.default_rng(0)
    path = rng.normal(size=(400, 8)).cumsum(axis=0)
    error = 1e-3
    found = gains(learned(error=error**2), path, path + error * rng.normal(size=path.shape))
    assert found[100:].mean() > 0.9


def test_noise_on_a_state_that_rests_is_averaged() -> None:
    rng = np.random.default_rng(0)
    estimate = learned(error=1e-5)
    noise, angles = 0.05, np.full(8, 1.0)
    estimates = []
    for _ in range(600):
        found, _ = estimate(angles + noise * rng.normal(size=8), np.zeros(8))
        estimates.append(found)
        estimate.predict(found, np.zeros(8))
    assert np.var(np.array(estimates)[100:], axis=0).max() < 0.3 * noise**2
    np.testing.assert_allclose(np.mean(estimates, axis=0), 1.0, atol=0.02)


def test_an_innovation_beyond_five_widths_is_taken_as_observed() -> None:
    rng = np.random.default_rng(0)
    estimate = learned(error=1e-6)
    rest = np.zeros(8)
    gains(estimate, 0.01 * rng.normal(size=(300, 8)), np.zeros((300, 8)))
    width = np.sqrt(estimate._innovation[0])
    assert 0.007 < width < 0.013
    away = rest.copy()
    away[:2] = 6.0 * width, 3.0 * width
    (found,) = gains(estimate, away[None], rest[None])
    assert found[0] == 1.0
    assert found[1] < 0.5


def test_a_turn_of_a_joint_is_no_innovation() -> None:
    estimate, angles = learned(), np.full(8, 0.3)
    estimate.predict(angles + 2 * np.pi, np.zeros(8))
    found, _ = estimate(angles, np.zeros(8))
    np.testing.assert_allclose(found, angles + 2 * np.pi, atol=1e-12)


def test_where_the_model_is_wrong_in_the_same_way_the_observation_counts() -> None:
    rng = np.random.default_rng(0)
    noise = 0.01 * rng.normal(size=(800, 8))
    white = gains(learned(error=1e-8), noise, np.zeros((800, 8)))
    assert white[100:].mean() < 0.15
    wrong = gains(learned(error=1e-8), noise + 0.03, np.zeros((800, 8)))
    np.testing.assert_allclose(wrong[200:].mean(), 0.9, atol=0.05)  # 0.03² / (0.03² + 0.01²)


def test_the_gain_stays_between_a_twentieth_and_1() -> None:
    rng = np.random.default_rng(0)
    estimate = learned(error=0.0)
    found = gains(estimate, rng.normal(size=(2000, 8)), np.zeros((2000, 8)))
    assert found.min() == 0.05
    assert found.max() <= 1.0


def test_the_models_error_only_falls() -> None:
    estimate = StateEstimate((2,))
    found = []
    for error in (3e-5, 1e-3, 1e-6, 1e-5, 0.0):
        estimate.learn(np.full(8, error), (1,))
        found.append(estimate.state_dict()["model_error"][1, 0])
    assert found == [3e-5, 3e-5, 1e-6, 1e-6, 1e-8]
    np.testing.assert_array_equal(estimate.state_dict()["model_error"][0], 1e-4)


def test_state_and_selected_runs_keep_the_models_error() -> None:
    estimate, other = StateEstimate((3,)), StateEstimate((3,))
    for run in range(3):
        estimate.learn(np.full(8, 10.0 ** -(5 + run)), (run,))
    other.load_state_dict(estimate.state_dict())
    other.select_runs(np.array([2, 0]))
    other.reset()
    expected = estimate.state_dict()["model_error"][[2, 0]]
    np.testing.assert_array_equal(other.state_dict()["model_error"], expected)
    other.predict(np.zeros((2, 8)), np.zeros((2, 8)))
    assert other(np.zeros((2, 8)), np.zeros((2, 8)))[0].shape == (2, 8)


def test_runs_of_a_batch_are_estimated_as_alone() -> None:
    rng = np.random.default_rng(0)
    observed, ahead = rng.normal(size=(2, 50, 3, 8))
    together = gains(learned((3,)), observed, ahead)
    for run in range(3):
        alone = gains(learned(), observed[:, run], ahead[:, run])
        np.testing.assert_array_equal(together[:, run], alone)
