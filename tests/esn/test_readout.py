import numpy as np
import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.esn import PRECISION, ReadoutBank, Ridge

T, M, F, K = 60, 3, 5, 2


@pytest.fixture
def data() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng.normal(size=(T, M, F)), rng.normal(size=(T, M, K)), rng.random((T, M))


def readout(forgetting: float = 0.0, ridge: float = 1e-12) -> ReadoutBank:
    return ReadoutBank(np.zeros((M, K, F)), forgetting=forgetting, ridge=Ridge(ridge))


def test_a_linear_relation_is_found_exactly(data: tuple[np.ndarray, ...]) -> None:
    z, _, _ = data
    truth = np.random.default_rng(1).normal(size=(M, K, F))
    bank = readout()
    bank.fit(z, np.einsum("mkf,tmf->tmk", truth, z))
    np.testing.assert_allclose(bank.weights, truth, atol=1e-5)
    np.testing.assert_allclose(bank(z[0]), np.einsum("mkf,mf->mk", truth, z[0]), atol=1e-5)


def test_weights_are_those_of_weighted_least_squares(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    bank = readout()
    bank.fit(z, y, w)
    for i in range(M):
        root = np.sqrt(w[:, i, None])
        expected = np.linalg.lstsq(root * z[:, i], root * y[:, i], rcond=None)[0]
        np.testing.assert_allclose(bank.weights[i].T, expected, atol=1e-6)


def test_ridge_shrinks_as_in_its_closed_form(data: tuple[np.ndarray, ...]) -> None:
    z, y, _ = data
    bank = readout(ridge=0.3)
    bank.fit(z, y)
    gram = z[:, 0].T @ z[:, 0] + 0.3 * T * np.eye(F)
    np.testing.assert_allclose(
        bank.weights[0].T, np.linalg.inv(gram) @ z[:, 0].T @ y[:, 0], atol=1e-6
    )


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
    np.testing.assert_allclose(halves.weights, whole.weights, atol=1e-6)


def test_targets_may_be_shared_by_modules(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    shared, each = readout(), readout()
    shared.fit(z, y[:, :1], w)
    each.fit(z, np.tile(y[:, :1], (1, M, 1)), w)
    np.testing.assert_array_equal(shared.weights, each.weights)


def test_a_copy_of_the_state_reads_alike(data: tuple[np.ndarray, ...]) -> None:
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


def test_a_partial_fit_is_a_step_of_normalised_lms() -> None:
    bank = ReadoutBank(np.array([[[1.0, -1.0]], [[0.0, 0.0]]]))
    bank.partial_fit(np.array([[3.0, 4.0], [1.0, 0.0]]), np.array([[0.5], [-2.0]]), rate=0.1)
    # zᵀz is 25 and 1, so that the weights move by 0.1 · 0.5 / 25 · [3, 4] and 0.1 · -2 · [1, 0].
    np.testing.assert_allclose(bank.weights, [[[1.006, -0.992]], [[-0.2, 0.0]]], atol=1e-6)


@pytest.mark.parametrize("rate", [0.25, 1.0, 1.5])
def test_partial_fits_leave_the_closed_forms_share_of_the_error(rate: float) -> None:
    rng = np.random.default_rng(0)
    z, y = rng.normal(size=(M, F)), rng.normal(size=(M, K))
    bank = ReadoutBank(np.zeros((M, K, F)))
    for step in range(4):
        np.testing.assert_allclose(y - bank(z), (1 - rate) ** step * y, atol=1e-5)
        bank.partial_fit(z, y - bank(z), rate)


def test_a_partial_fit_on_zero_features_changes_nothing() -> None:
    bank = ReadoutBank(np.ones((M, K, F)))
    bank.partial_fit(np.zeros((M, F)), np.ones((M, K)), 1.0)
    np.testing.assert_array_equal(bank.weights, 1.0)


def side_by_side(data: tuple[np.ndarray, ...], members: int = 3) -> ReadoutBank:
    """Return readouts of members, of which each has learned something else."""
    z, y, w = data
    bank = ReadoutBank(np.zeros((members, M, K, F)), forgetting=0.7, ridge=Ridge(1e-3))
    for i in range(members):
        bank.of_run((i,)).fit(z, (i + 1) * y, w)
    return bank


def test_selected_runs_read_and_learn_as_before(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    bank, whole = side_by_side(data), side_by_side(data)
    bank.select_runs(np.array([2, 0]))
    for row, member in enumerate((2, 0)):
        np.testing.assert_array_equal(bank.weights[row], whole.weights[member])
        for own, index in ((bank, row), (whole, member)):
            own.of_run((index,)).fit(z[::-1], y, w)
        np.testing.assert_array_equal(bank.weights[row], whole.weights[member])
        assert np.abs(bank.weights[row]).max() > 0.01


def test_runs_of_readouts_that_were_never_fitted_can_be_selected() -> None:
    bank = ReadoutBank(np.arange(3.0 * M * K * F).reshape(3, M, K, F))
    kept = bank.weights[[1]]
    bank.select_runs(np.array([1]))
    np.testing.assert_array_equal(bank.weights, kept)


def test_fitting_a_run_fits_the_whole(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    bank, alone = side_by_side(data), readout(0.7, 1e-3)
    alone.load_state_dict({name: value[1] for name, value in bank.state_dict().items()})
    before = bank.state_dict()
    bank.of_run((1,)).fit(z[::-1], y, w)
    alone.fit(z[::-1], y, w)
    for name, value in bank.state_dict().items():
        np.testing.assert_array_equal(value[1], alone.state_dict()[name])
        np.testing.assert_array_equal(value[[0, 2]], before[name][[0, 2]])


def test_features_of_fewer_modules_read_and_fit_the_first(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    part, whole = readout(0.7), readout(0.7)
    part.fit(z[:, :2], y[:, :2], w)  # weights may be those of all modules
    whole.fit(z, y, w)
    np.testing.assert_array_equal(part(z[0, :2]), whole(z[0])[:2])
    np.testing.assert_array_equal(part.outputs(z[:, :2])[:, 1], whole.outputs(z)[:, 1])
    for name, value in part.state_dict().items():
        np.testing.assert_array_equal(value[:2], whole.state_dict()[name][:2])
        assert not value[2].any()


@pytest.mark.parametrize("ridge", [Ridge(0.02), Ridge(0.0, 0.3), Ridge(0.02, 0.3)])
def test_ridge_is_in_proportion_to_the_modules_own_weight_and_to_each_feature(
    ridge: Ridge, data: tuple[np.ndarray, ...]
) -> None:
    z, y, w = data
    bank = ReadoutBank(np.zeros((M, K, F)), ridge=ridge)
    bank.fit(z, y, w)
    for i in range(M):
        gram = z[:, i].T @ (w[:, i, None] * z[:, i])
        regular = gram + ridge.absolute * w[:, i].sum() * np.eye(F)
        regular += ridge.relative * np.diag(np.diag(gram))
        expected = np.linalg.solve(regular, z[:, i].T @ (w[:, i, None] * y[:, i]))
        np.testing.assert_allclose(bank.weights[i].T, expected, atol=2e-6)


def test_with_a_relative_ridge_the_unit_of_a_feature_does_not_matter(
    data: tuple[np.ndarray, ...],
) -> None:
    z, y, w = data
    unit = np.array([1.0, 100.0, 1.0, 0.01, 1.0])
    banks = [ReadoutBank(np.zeros((M, K, F)), ridge=Ridge(0.0, 0.3)) for _ in range(2)]
    banks[0].fit(z, y, w)
    banks[1].fit(z * unit, y, w)
    np.testing.assert_allclose(banks[1].weights * unit, banks[0].weights, atol=1e-5)


def test_a_module_with_less_than_a_step_stays_as_it_is(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    bank, other = readout(0.7), readout(0.7)
    for one in (bank, other):
        one.fit(z, y, w)
    before = bank.state_dict()
    few = w.copy()
    few[:, 1] *= 0.99 / few[:, 1].sum()
    bank.fit(z[::-1], 2 * y, few)
    other.fit(z[::-1], 2 * y, w)
    for name, value in bank.state_dict().items():
        np.testing.assert_array_equal(value[1], before[name][1])
        np.testing.assert_array_equal(value[[0, 2]], other.state_dict()[name][[0, 2]])
        assert not np.array_equal(value[0], before[name][0])


def test_sums_are_in_a_state_only_where_epochs_add_up(data: tuple[np.ndarray, ...]) -> None:
    z, y, w = data
    for forgetting, names in ((0.0, set()), (0.7, {"gram", "moment"})):
        bank = readout(forgetting)
        bank.fit(z, y, w)
        assert bank.state_dict().keys() == {"weights", "steps"} | names


def test_a_state_from_before_the_first_fit_undoes_fits(
    data: tuple[np.ndarray, ...],
) -> None:
    z, y, w = data
    untouched, used, fresh = readout(0.7), readout(0.7), readout(0.7)
    used.fit(z * 3, y, w)
    used.load_state_dict(untouched.state_dict())
    np.testing.assert_array_equal(used.weights, 0.0)
    for bank in (used, fresh):
        bank.fit(z, y, w)
    np.testing.assert_array_equal(used.weights, fresh.weights)


@pytest.mark.parametrize("name", ["weights", "steps", "gram", "moment"])
def test_a_state_that_lacks_something_is_refused_by_its_name(
    name: str, data: tuple[np.ndarray, ...]
) -> None:
    z, y, w = data
    bank = readout(0.7)
    bank.fit(z, y, w)
    state = {f"own.{key}": value for key, value in bank.state_dict().items() if key != name}
    with pytest.raises(KeyError, match=f"own.{name}"):
        bank.load_state_dict(state, "own.")


@pytest.mark.parametrize("ridge", [1e-4, 1e-6, 1e-9])
def test_dependent_features_are_fitted_with_any_small_ridge(ridge: float) -> None:
    rng = np.random.default_rng(0)
    few = rng.normal(size=(300, 1, 5))
    z = np.concatenate([few, few @ rng.normal(size=(5, 40))], axis=2).astype(PRECISION)
    bank = ReadoutBank(np.zeros((1, 2, 45)), ridge=Ridge(ridge))
    y = few[..., :2]
    bank.fit(z, y)
    np.testing.assert_allclose([bank(row) for row in z], y, atol=5e-3)


def test_a_ridge_that_is_too_small_is_refused() -> None:
    bank = ReadoutBank(np.zeros((1, 1, 3)), ridge=Ridge(1e-300))
    with pytest.raises(BadOptionError, match="ridge is 1e-300; expected a ridge large enough"):
        bank.fit(np.ones((4, 1, 3), PRECISION), np.ones((4, 1, 1)))
