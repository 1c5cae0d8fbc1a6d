import numpy as np
import pytest

from mpma_mj.esn import ReadoutBank

T, M, F, K = 60, 3, 5, 2


@pytest.fixture
def data() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng.normal(size=(T, M, F)), rng.normal(size=(T, M, K)), rng.random((T, M))


def readout(forgetting: float = 0.0, ridge: float = 1e-12) -> ReadoutBank:
    return ReadoutBank(np.zeros((M, K, F)), forgetting=forgetting, ridge=ridge)


def test_a_linear_relation_is_found_exactly(data: tuple[np.ndarray, ...]) -> None:
    z, _, _ = data
    truth = np.random.default_rng(1).normal(size=(M, K, F))
    bank = readout()
    bank.fit(z, np.einsum("mkf,tmf->tmk", truth, z))
    np.testing.assert_allclose(bank.weights, truth, atol=1e-9)
    np.testing.assert_allclose(bank(z[0]), np.einsum("mkf,mf->mk", truth, z[0]), atol=1e-9)


def test_weights_are_those_of_weighted_least_squares(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    bank = readout()
    bank.fit(z, y, w)
    for i in range(M):
        root = np.sqrt(w[:, i, None])
        expected = np.linalg.lstsq(root * z[:, i], root * y[:, i], rcond=None)[0]
        np.testing.assert_allclose(bank.weights[i].T, expected, atol=1e-8)


def test_ridge_shrinks_as_its_closed_form_says(data: tuple[np.ndarray, ...]) -> None:
    z, y, _ = data
    bank = readout(ridge=0.3)
    bank.fit(z, y)
    gram = z[:, 0].T @ z[:, 0] + 0.3 * T * np.eye(F)
    np.testing.assert_allclose(bank.weights[0].T, np.linalg.inv(gram) @ z[:, 0].T @ y[:, 0])


def test_without_forgetting_factor_only_the_last_epoch_counts(
    data: tuple[np.ndarray, ...],
) -> None:
    z, y, w = data
    twice, once = readout(), readout()
    twice.fit(z[::-1] * 2, y, w)
    twice.fit(z, y, w)
    once.fit(z, y, w)
    np.testing.assert_allclose(twice.weights, once.weights)


def test_with_full_memory_epochs_add_up(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    halves, whole = readout(1.0, 0.01), readout(1.0, 0.01)
    halves.fit(z[:20], y[:20], w[:20])
    halves.fit(z[20:], y[20:], w[20:])
    whole.fit(z, y, w)
    np.testing.assert_allclose(halves.weights, whole.weights)


def test_targets_may_be_shared_by_modules(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    shared, each = readout(), readout()
    shared.fit(z, y[:, :1], w)
    each.fit(z, np.tile(y[:, :1], (1, M, 1)), w)
    np.testing.assert_array_equal(shared.weights, each.weights)


def test_state_goes_round(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    one, other = readout(0.7), readout(0.7)
    one.fit(z, y, w)
    other.load_state_dict(one.state_dict())
    one.fit(z, y * 2, w)
    other.fit(z, y * 2, w)
    np.testing.assert_array_equal(one.weights, other.weights)


def test_state_is_a_copy(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    bank = readout(0.7)
    bank.fit(z, y, w)
    state = bank.state_dict()
    before = {name: value.copy() for name, value in state.items()}
    bank.fit(z, y * 2, w)
    for name, value in before.items():
        np.testing.assert_array_equal(state[name], value)


def test_a_nudge_is_a_step_of_normalised_lms() -> None:
    bank = ReadoutBank(np.array([[[1.0, -1.0]], [[0.0, 0.0]]]))
    bank.nudge(np.array([[3.0, 4.0], [1.0, 0.0]]), np.array([[0.5], [-2.0]]), rate=0.1)
    # zᵀz is 25 and 1, so that the weights move by 0.1 · 0.5 / 25 · [3, 4] and 0.1 · -2 · [1, 0].
    np.testing.assert_allclose(bank.weights, [[[1.006, -0.992]], [[-0.2, 0.0]]], atol=1e-6)


@pytest.mark.parametrize("rate", [0.25, 1.0, 1.5])
def test_nudges_leave_the_closed_forms_share_of_the_error(rate: float) -> None:
    rng = np.random.default_rng(0)
    z, y = rng.normal(size=(M, F)), rng.normal(size=(M, K))
    bank = ReadoutBank(np.zeros((M, K, F)))
    for step in range(4):
        np.testing.assert_allclose(y - bank(z), (1 - rate) ** step * y, atol=1e-5)
        bank.nudge(z, y - bank(z), rate)


def test_a_nudge_on_silent_features_changes_nothing() -> None:
    bank = ReadoutBank(np.ones((M, K, F)))
    bank.nudge(np.zeros((M, F)), np.ones((M, K)), 1.0)
    np.testing.assert_array_equal(bank.weights, 1.0)
