"""Plant models of artificial linear plants, of which everything is known."""

from typing import Any

import numpy as np
import pytest

from mpma_mj.agents.plant_models import (
    PLANT_INPUTS,
    PlantModels,
    gaussian_log_likelihood,
    novelty,
    plant_inputs,
)

Array = np.ndarray

STEPS = 300
WIDTH = 0.05  # of the noise on moves, far above the least width


def linear_plant(seed: int) -> Array:
    """Return A of a plant, shape (8, 33), that mostly does what it is commanded."""
    own = 0.05 * np.random.default_rng(seed).normal(size=(8, PLANT_INPUTS))
    own[:, :8] += np.eye(8)
    return own


FIRST, SECOND, THIRD = (linear_plant(seed) for seed in (1, 2, 3))
SECOND[:, :8] -= 0.5 * np.eye(8)
THIRD[:, :8] += 0.7 * np.eye(8)


def joint_state(angles: Array, relative: Array) -> Array:
    """Return a proprioceptive state, (..., 36), of angles, rad, and relative velocities."""
    posture = np.full((*angles.shape[:-1], 12), np.nan)  # which no plant model receives
    return np.concatenate([posture, np.sin(angles), np.cos(angles), relative], axis=-1)


def episode(
    seed: int, *plants: Array, width: float = 0.0, steps: int = STEPS
) -> tuple[Array, Array]:
    """Return inputs and moves of an episode that plants share in equal parts, one by one."""
    rng = np.random.default_rng(seed)
    action, angles = rng.uniform(-1, 1, (steps, 8)), rng.uniform(-2, 2, (steps, 8))
    inputs = plant_inputs(action, joint_state(angles, rng.normal(size=(steps, 8)) / 12.0))
    parts = np.array_split(inputs, len(plants))
    moves = np.concatenate([part @ own.T for part, own in zip(parts, plants, strict=True)])
    return inputs, moves + width * rng.normal(size=moves.shape)


def models(
    most: int = 3, batch_shape: tuple[int, ...] = (), limit: float = 3.0, guarded: bool = False
) -> PlantModels:
    return PlantModels(
        batch_shape,
        most=most,
        novelty=limit,
        switching_probability=0.03,
        guarded_recruitment=guarded,
    )


def learned(
    *epochs: tuple[Array, ...], most: int = 3, width: float = WIDTH, steps: int = STEPS
) -> PlantModels:
    made = models(most)
    for seed, plants in enumerate(epochs):
        made.learn(*episode(seed, *plants, width=width, steps=steps))
    return made


def test_inputs_are_action_state_and_one() -> None:
    rng = np.random.default_rng(0)
    action, angles, velocities = rng.normal(size=(3, 5, 8))
    expected = [action, np.sin(angles), np.cos(angles), velocities, np.ones((5, 1))]
    state = joint_state(angles, velocities)
    history = np.concatenate([state, rng.normal(size=(5, 16))], axis=1)
    for seen in (state, history):
        found = plant_inputs(action, seen)
        np.testing.assert_array_equal(found, np.concatenate(expected, axis=1))


def test_log_likelihood_is_that_of_independent_gaussians_up_to_a_constant() -> None:
    rng = np.random.default_rng(0)
    errors, variance = rng.normal(size=(6, 8)), rng.uniform(0.1, 2.0, 8)
    density = np.exp(-(errors**2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
    expected = np.log(density).sum(axis=1) + 4 * np.log(2 * np.pi)
    np.testing.assert_allclose(gaussian_log_likelihood(errors, variance), expected)


def test_beyond_the_cap_a_larger_error_changes_nothing() -> None:
    variance = np.full(8, 0.01)
    three, far = np.full(8, 0.3), np.full(8, 1e6)
    at_cap = gaussian_log_likelihood(three, variance, 9.0)
    assert at_cap == pytest.approx(gaussian_log_likelihood(three, variance))
    assert gaussian_log_likelihood(far, variance, 9.0) == pytest.approx(at_cap)
    assert gaussian_log_likelihood(0.9 * three, variance, 9.0) > at_cap


def test_an_exactly_linear_plant_is_recovered() -> None:
    made = learned((FIRST,), (FIRST,), width=0.0)
    # The ridge, 1e-4 a step and divided by the number of plants, leaves a bias; velocities are
    # small, so that it is largest there.
    inputs, moves = episode(9, FIRST)
    np.testing.assert_allclose(made.moves(inputs, 1)[:, 0], moves, atol=2e-3)
    np.testing.assert_allclose(made.weights[0], FIRST, atol=2e-3)
    exact = np.linalg.solve(made.gram[0], made.moment[0]).T
    np.testing.assert_allclose(exact, FIRST, atol=1e-10)
    np.testing.assert_array_equal(made.variance[0], 2e-4)  # the least


def test_weights_are_those_of_ridge_regression_over_all_epochs() -> None:
    made = learned((FIRST,), (FIRST,), (FIRST,))
    data = [episode(seed, FIRST, width=WIDTH) for seed in range(3)]
    inputs, moves = (np.concatenate(both) for both in zip(*data, strict=True))
    regular = inputs.T @ inputs + 1e-4 * STEPS / 3 * np.eye(PLANT_INPUTS)
    np.testing.assert_allclose(made.weights[0], np.linalg.solve(regular, inputs.T @ moves).T)
    np.testing.assert_allclose(made.gram[0], inputs.T @ inputs)
    np.testing.assert_allclose(made.moment[0], inputs.T @ moves)


def test_novelty_is_about_1_for_noise_of_the_measured_width_and_larger_for_another_plant() -> None:
    made = learned((FIRST,), (FIRST,), steps=20 * STEPS)  # so many that little is unknown
    np.testing.assert_allclose(made.variance[0], WIDTH**2, rtol=0.1)

    def novelty_of(*plants: Array, width: float = WIDTH) -> Array:
        inputs, moves = episode(7, *plants, width=width)
        errors = made.moves(inputs, 1) - moves[:, None]
        return novelty(errors, made.variance[:1], made.gram[:1], inputs)

    inside = slice(5, -5)  # the window ends where the episode does
    known = novelty_of(FIRST)
    assert known.shape == (STEPS,)
    assert known[inside].mean() == pytest.approx(1.0, abs=0.1)
    assert known.max() < 2.0
    assert novelty_of(FIRST, width=2 * WIDTH)[inside].mean() == pytest.approx(4.0, rel=0.1)
    assert novelty_of(SECOND)[inside].min() > 3.0
    assert novelty_of(SECOND, width=0.0).max() <= 100.0 + 1e-9  # the cap
    half = novelty_of(FIRST, SECOND)
    assert half[: STEPS // 2 - 5].max() < 2.0
    assert half[STEPS // 2 + 5 : -5].min() > 3.0


def test_novelty_counts_the_plant_model_that_is_nearest() -> None:
    made = learned((FIRST,), (FIRST,), (SECOND,))
    inputs, moves = episode(7, FIRST, SECOND, width=WIDTH)
    errors = made.moves(inputs, 2) - moves[:, None]
    assert novelty(errors, made.variance[:2], made.gram[:2], inputs).max() < 2.0


def test_a_plant_model_may_err_where_it_has_never_been() -> None:
    gram = np.eye(PLANT_INPUTS)[None] * 1e4
    gram[0, 0, 0] = 0.0  # the first action was never moved
    inputs = np.zeros((40, PLANT_INPUTS))
    inputs[:, 1] = 1.0
    errors, variance = np.full((40, 1, 8), 0.1), np.full((1, 8), 0.01)
    assert novelty(errors, variance, gram, inputs)[20] == pytest.approx(1.0, abs=0.01)
    inputs[:, 0] = 1.0
    assert novelty(errors, variance, gram, inputs)[20] < 1e-3


def test_the_first_plants_widths_are_those_of_its_second_epoch_and_stay() -> None:
    made = models()
    made.learn(*episode(0, FIRST, width=3 * WIDTH))
    np.testing.assert_allclose(made.variance[0], (3 * WIDTH) ** 2, rtol=0.5)
    made.learn(*episode(1, FIRST, width=WIDTH))
    second = made.variance.copy()
    assert (second[0] < 3 * WIDTH**2).all()
    for seed in range(2, 5):
        made.learn(*episode(seed, FIRST, width=1.2 * WIDTH))
    np.testing.assert_array_equal(made.variance, second)
    assert made.epochs == 5


def test_no_plant_is_recruited_in_the_first_two_epochs() -> None:
    made = models()
    for seed, plants in enumerate([(FIRST, SECOND), (SECOND,)]):
        posterior, recruits = made.learn(*episode(seed, *plants, width=WIDTH))
        assert not recruits
        np.testing.assert_array_equal(posterior, np.eye(3)[np.zeros(STEPS, int)])
    assert made.recruited == 1


def test_a_second_plant_is_recruited_once_and_has_its_steps() -> None:
    made = learned((FIRST,), (FIRST,))
    posterior, recruits = made.learn(*episode(2, FIRST, SECOND, width=WIDTH))
    assert recruits
    assert made.recruited == 2
    half = STEPS // 2
    np.testing.assert_allclose(posterior[: half - 1, 0], 1.0, atol=1e-3)
    np.testing.assert_allclose(posterior[half + 1 :, 1], 1.0, atol=1e-3)
    for seed in range(3, 6):
        posterior, recruits = made.learn(*episode(seed, SECOND, FIRST, width=WIDTH))
        assert not recruits
        np.testing.assert_allclose(posterior[: half - 1, 1], 1.0, atol=1e-3)
    assert made.recruited == 2
    inputs, moves = episode(9, SECOND)
    np.testing.assert_allclose(made.moves(inputs, 2)[:, 1], moves, atol=WIDTH)
    np.testing.assert_allclose(made.variance[1], WIDTH**2, rtol=0.6)


def recruited(guarded: bool, *plants: Array) -> tuple[PlantModels, PlantModels, Array]:
    """Return models before and after an epoch in which a plant is recruited, and its posterior."""
    after = models(guarded=guarded)
    for seed in range(2):
        after.learn(*episode(seed, FIRST, width=WIDTH))
    before = models()
    for name, array in after.arrays().items():
        before.arrays()[name][...] = array
    posterior, recruits = after.learn(*episode(2, *plants, width=WIDTH))
    assert recruits
    return before, after, posterior


def test_where_recruitment_is_guarded_other_plants_learn_nothing_in_that_epoch() -> None:
    before, after, posterior = recruited(True, FIRST, SECOND)
    assert posterior[:, 0].sum() > 0.4 * STEPS  # steps that it would have learned from
    for name in ("weights", "variance", "gram", "moment"):
        np.testing.assert_array_equal(after.arrays()[name][0], before.arrays()[name][0])
    after.learn(*episode(3, FIRST, SECOND, width=WIDTH))
    assert np.abs(after.gram[0] - before.gram[0]).max() > 10.0


def test_where_recruitment_is_not_guarded_other_plants_learn_in_that_epoch() -> None:
    before, after, posterior = recruited(False, FIRST, SECOND)
    inputs, _ = episode(2, FIRST, SECOND)
    for w in (0, 1):
        own = inputs.T @ (posterior[:, w, None] * inputs)
        np.testing.assert_allclose(after.gram[w], before.gram[w] + own)


def test_a_plant_whose_recruitment_is_guarded_begins_with_twenty_steps_of_its_parent() -> None:
    before, after, posterior = recruited(True, FIRST, SECOND)
    inputs, moves = episode(2, FIRST, SECOND, width=WIDTH)
    own, share = posterior[:, 1, None] * inputs, 20.0 / (2 * STEPS)
    gram = share * before.gram[0] + own.T @ inputs
    moment = share * before.moment[0] + own.T @ moves
    np.testing.assert_allclose(after.gram[1], gram)
    np.testing.assert_allclose(after.moment[1], moment)
    np.testing.assert_allclose(after.weights[1], np.linalg.solve(gram, moment).T, atol=0.01)
    errors = posterior[:, 1, None] * (after.moves(inputs, 2)[:, 1] - moves) ** 2
    np.testing.assert_allclose(after.variance[1], errors.sum(axis=0) / own[:, -1].sum(), rtol=0.1)


def test_the_parent_is_the_plant_that_was_taken_for_it() -> None:
    made = models(guarded=True)
    for seed, plants in enumerate([(FIRST,), (FIRST,), (SECOND,), (SECOND,)]):
        made.learn(*episode(seed, *plants, width=WIDTH))
    assert made.recruited == 2
    likewise = 1.5 * SECOND - 0.5 * FIRST  # nearer to the second
    gram = made.gram.copy()
    posterior, recruits = made.learn(*episode(4, likewise, width=WIDTH))
    assert recruits
    inputs, _ = episode(4, likewise)
    inherited = made.gram[2] - inputs.T @ (posterior[:, 2, None] * inputs)
    np.testing.assert_allclose(inherited, 20.0 * gram[1] / gram[1, -1, -1], atol=1e-8)


def test_a_plant_of_too_few_steps_is_not_recruited() -> None:
    made = learned((FIRST,), (FIRST,))
    inputs, moves = episode(2, FIRST, width=WIDTH)
    few = 12  # with the window these are 20 steps or more, but not a tenth of the epoch
    moves[100 : 100 + few] = inputs[100 : 100 + few] @ SECOND.T
    _, recruits = made.learn(inputs, moves)
    assert not recruits
    assert made.recruited == 1


def test_what_is_learned_in_one_plant_leaves_the_other_as_it_is() -> None:
    made = learned((FIRST,), (FIRST,), (SECOND,))
    before = {name: array.copy() for name, array in made.arrays().items()}
    made.learn(*episode(7, SECOND, width=WIDTH))
    np.testing.assert_allclose(made.weights[0], before["weights"][0], atol=1e-4)
    np.testing.assert_array_equal(made.variance, before["variance"])
    assert np.abs(made.weights[1] - before["weights"][1]).max() > 1e-3


@pytest.mark.parametrize("most", [1, 2, 3])
def test_there_are_never_more_plants_than_the_most(most: int) -> None:
    made = learned((FIRST,), (FIRST,), (SECOND,), (THIRD,), (linear_plant(7) - FIRST,), most=most)
    assert made.recruited == most
    assert made.weights.shape == (most, 8, PLANT_INPUTS)


def test_posteriors_sum_to_1_over_recruited_plants() -> None:
    made = models()
    for seed, plants in enumerate([(FIRST,), (FIRST,), (SECOND, FIRST), (FIRST, THIRD)]):
        posterior, _ = made.learn(*episode(seed, *plants, width=WIDTH))
        assert posterior.shape == (STEPS, 3)
        np.testing.assert_allclose(posterior.sum(axis=1), 1.0)
        assert not posterior[:, int(made.recruited) :].any()


def test_the_models_of_a_run_share_memory_with_the_batch() -> None:
    batch, alone = models(batch_shape=(3,)), models()
    for seed, plants in enumerate([(FIRST,), (FIRST,), (SECOND,)]):
        data = episode(seed, *plants, width=WIDTH)
        one, _ = batch.of_run((1,)).learn(*data)
        other, _ = alone.learn(*data)
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(batch.recruited, [1, 2, 1])
    np.testing.assert_array_equal(batch.epochs, [0, 3, 0])
    for name, array in alone.arrays().items():
        np.testing.assert_array_equal(batch.arrays()[name][1], array)
    inputs, _ = episode(9, FIRST)
    stacked = np.stack([inputs[0]] * 3)
    np.testing.assert_array_equal(batch.moves(stacked, 2)[1], alone.moves(inputs[0], 2))
    whole = models()
    whole.of_run(()).learn(*episode(0, FIRST))
    assert whole.epochs == 1
    assert whole.weights.any()


def test_selected_runs_keep_their_models() -> None:
    batch = models(batch_shape=(3,))
    for run in range(3):
        batch.of_run((run,)).learn(*episode(run, linear_plant(run)))
    before: dict[str, Any] = {name: array.copy() for name, array in batch.arrays().items()}
    batch.select_runs(np.array([2, 0]))
    for name, array in batch.arrays().items():
        np.testing.assert_array_equal(array, before[name][[2, 0]])
