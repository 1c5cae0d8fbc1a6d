import numpy as np
import pytest

from mpma_mj.esn import PRECISION, ReservoirBank, initializers, reservoir
from mpma_mj.esn.initializers import random_recurrence


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def bank(count: int = 3, inputs: int = 4, nodes: int = 20, noise: float = 0.0) -> ReservoirBank:
    return ReservoirBank((), count, inputs, nodes, radius=0.9, noise=noise, streams=[rng()])


@pytest.mark.parametrize("nodes", [1, 5, 50, 200])
def test_recurrence_has_the_spectral_radius_and_few_connections(nodes: int) -> None:
    matrix = random_recurrence(nodes, 0.1, rng())
    eigenvalues = np.linalg.eigvals(matrix.toarray())
    assert np.abs(eigenvalues).max() == pytest.approx(0.1)
    assert (np.diff(matrix.indptr) == min(10, nodes)).all()


def test_a_bank_equals_its_reservoirs_one_by_one() -> None:
    together = bank()
    recurrence, weights = together._recurrence.toarray(), together._input_weights
    states = np.zeros((3, 20))
    for t in range(5):
        v = rng(t).normal(size=(3, 4))
        features = together.step(v)
        for i in range(3):
            block = recurrence[20 * i : 20 * (i + 1), 20 * i : 20 * (i + 1)]
            states[i] = np.tanh(block @ states[i] + weights[i] @ v[i])
        np.testing.assert_allclose(features[:, :20], states, atol=1e-6)
        np.testing.assert_array_equal(features[:, 20:], v.astype(PRECISION))


def test_one_input_for_all_is_the_same_as_one_for_each() -> None:
    v = rng(1).normal(size=4)
    shared, each = bank().step(v), bank().step(np.tile(v, (3, 1)))
    np.testing.assert_allclose(shared, each, atol=1e-15)


def test_input_weights_are_uniform_between_minus_one_and_one() -> None:
    weights = bank(nodes=400)._input_weights
    assert np.abs(weights).max() <= 1.0
    assert weights.mean() == pytest.approx(0.0, abs=0.03)
    assert weights.std() == pytest.approx(1 / np.sqrt(3), rel=0.02)


def test_reservoirs_differ() -> None:
    features = bank().step(np.ones(4))
    assert not np.allclose(features[0], features[1])


def test_states_forget_where_they_began() -> None:
    one, other = bank(), bank()
    other.step(np.full(4, 3.0))
    for t in range(200):
        v = rng(t).normal(size=4)
        difference = one.step(v) - other.step(v)
    assert np.abs(difference).max() < 1e-6


def test_noise_is_uniform_of_the_given_width() -> None:
    quiet, noisy = bank(nodes=400), bank(nodes=400, noise=0.2)
    difference = noisy.step(np.ones(4)) - quiet.step(np.ones(4))
    assert np.abs(difference).max() <= 0.1
    assert difference[:, :400].std() == pytest.approx(0.2 / np.sqrt(12), rel=0.05)
    assert (difference[:, 400:] == 0).all()


def test_reset_sets_states_to_zero() -> None:
    used = bank()
    first = used.step(np.ones(4))
    used.step(np.ones(4))
    used.reset([rng()])
    np.testing.assert_array_equal(used.step(np.ones(4)), first)


def test_selected_runs_continue_as_they_would_alone() -> None:
    def streams(*members: int) -> list[np.random.Generator]:
        return [rng(10 + member) for member in members]

    options = {"radius": 0.9, "noise": 0.2}
    together = ReservoirBank((3,), 2, 4, 20, streams=streams(0, 1, 2), **options)
    v = rng(5).normal(size=(6, 3, 4))
    together.step(v[0])
    together.select_runs(np.array([2, 0]))
    together.reset(streams(2, 0))
    for row, member in enumerate((2, 0)):
        alone = ReservoirBank((), 2, 4, 20, streams=streams(member), **options)
        alone.reset(streams(member))
        together.reset(streams(2, 0))
        for inputs in v:
            features = together.step(inputs[[2, 0]])
            np.testing.assert_allclose(features[row], alone.step(inputs[member]), atol=1e-15)


def run_streams(batch_shape: tuple[int, ...], seed: int) -> list[np.random.Generator]:
    return [rng(seed), rng(seed + 1)][: batch_shape[0] if batch_shape else 1]


@pytest.mark.parametrize("batch_shape", [(), (2,)])
def test_a_bank_of_two_groups_steps_as_two_banks(batch_shape: tuple[int, ...]) -> None:
    def made(seed: int) -> ReservoirBank:
        streams = run_streams(batch_shape, seed)
        return ReservoirBank(batch_shape, 3, 4, 20, radius=0.9, noise=0.2, streams=streams)

    both, first, second = made(10), made(10), made(30)
    both.extend(run_streams(batch_shape, 30))
    assert both.shape == (*batch_shape, 6, 24)
    both.reset(run_streams(batch_shape, 20), run_streams(batch_shape, 40))
    first.reset(run_streams(batch_shape, 20))
    second.reset(run_streams(batch_shape, 40))
    for t in range(20):  # more than are drawn at once
        v = rng(t).normal(size=(*batch_shape, 4))
        apart = np.concatenate([first.step(v), second.step(v)], axis=-2)
        np.testing.assert_array_equal(both.step(v), apart)


def test_a_run_and_selected_runs_have_all_groups() -> None:
    options = {"radius": 0.9, "noise": 0.2}
    together = ReservoirBank((2,), 3, 4, 20, streams=run_streams((2,), 10), **options)
    together.extend(run_streams((2,), 30))
    alone = ReservoirBank((), 3, 4, 20, streams=[rng(11)], **options)
    alone.extend([rng(31)])
    part = together.of_run((1,))
    together.select_runs(np.array([1]))
    for bank in (alone, part, together):
        bank.reset([rng(50)], [rng(60)])
    for t in range(20):
        v = rng(t).normal(size=4)
        expected = alone.step(v)
        np.testing.assert_array_equal(part.step(v), expected)
        np.testing.assert_array_equal(together.step(v[None])[0], expected)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("batch_shape", [(), (2,)])
def test_small_reservoirs_step_as_with_sparse_recurrences(
    batch_shape: tuple[int, ...], count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stepped() -> np.ndarray:
        streams = [rng(10), rng(11)][: batch_shape[0] if batch_shape else 1]
        options = {"radius": 0.9, "noise": 0.2}
        made = ReservoirBank(batch_shape, 3, 4, 20, streams=streams, **options)
        for group in range(1, count):
            made.extend([rng(20 * group + i) for i in range(len(streams))])
        groups = [[rng(30 + 10 * group + i) for i in range(len(streams))] for group in range(count)]
        made.reset(*groups)
        return np.stack([made.step(rng(t).normal(size=(*batch_shape, 4))) for t in range(9)])

    full = stepped()
    monkeypatch.setattr(reservoir, "_FULL", 0)
    np.testing.assert_allclose(full, stepped(), atol=1e-6)


@pytest.mark.parametrize("ahead", [1, 7])
def test_noise_does_not_depend_on_how_much_is_drawn_at_once(
    ahead: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stepped() -> np.ndarray:
        made = bank(noise=0.2)
        made.reset([rng(3)])
        return np.stack([made.step(np.ones(4)) for _ in range(80)])

    usual = stepped()
    monkeypatch.setattr(reservoir, "_DRAWN_AHEAD", ahead)
    np.testing.assert_array_equal(usual, stepped())


@pytest.mark.parametrize("nodes", [40, 80])
def test_a_radius_is_computed_once_for_the_same_weights_and_anew_for_others(nodes: int) -> None:
    initializers._radius.cache_clear()
    first, again = (random_recurrence(nodes, 0.1, rng(1)) for _ in range(2))
    assert initializers._radius.cache_info().hits == 1
    np.testing.assert_array_equal(first.toarray(), again.toarray())
    random_recurrence(nodes, 0.1, rng(2))
    assert initializers._radius.cache_info().misses == 2
