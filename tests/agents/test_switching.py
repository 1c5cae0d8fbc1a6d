"""Hidden Markov model of plants: laws, and comparison with sums over all paths."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj.agents.switching import filtered, predicted, smoothed

Array = np.ndarray

logs = st.floats(-1e4, 1e4)
probabilities = st.floats(1e-4, 0.5)


@st.composite
def beliefs(draw: st.DrawFn) -> tuple[Array, Array]:
    """Return a belief over states of which some are not enabled, and which are."""
    states = draw(st.integers(1, 5))
    enabled = draw(arrays(bool, states))
    weight = draw(arrays(np.float64, states, elements=st.floats(0.01, 1.0))) * enabled
    return weight / max(weight.sum(), 1e-9), enabled


@given(beliefs(), probabilities, st.data())
def test_beliefs_sum_to_1_and_leave_states_that_are_not_enabled_out(
    belief: tuple[Array, Array], h: float, data: st.DataObject
) -> None:
    before, enabled = belief
    log_likelihood = data.draw(arrays(np.float64, len(before), elements=logs))
    prior = predicted(before, enabled, h)
    after = filtered(prior, log_likelihood)
    for now in (prior, after):
        assert (now >= 0.0).all()
        assert not now[~enabled].any()
        assert now.sum() == pytest.approx(1.0 if enabled.any() else 0.0)


def test_each_run_has_states_of_its_own() -> None:
    enabled = np.array([[True, False, False], [True, True, False], [True, True, True]])
    belief = enabled / enabled.sum(axis=1, keepdims=True)
    prior = predicted(belief, enabled, 0.2)
    np.testing.assert_allclose(prior, belief)
    evidence = np.log([[0.1, 0.3, 0.6]] * 3)
    after = filtered(prior, evidence)
    np.testing.assert_allclose(after, [[1, 0, 0], [0.25, 0.75, 0], [0.1, 0.3, 0.6]])


def test_a_belief_after_evidence_is_bayes_rule() -> None:
    prior, likelihood = np.array([0.7, 0.2, 0.1]), np.array([1e-3, 5e-3, 2e-3])
    expected = prior * likelihood / (prior @ likelihood)
    np.testing.assert_allclose(filtered(prior, np.log(likelihood)), expected, rtol=1e-12)
    np.testing.assert_allclose(filtered(prior, np.log(likelihood) - 1e6), expected, rtol=1e-6)


def test_a_state_that_was_impossible_returns() -> None:
    belief, enabled = np.array([0.5, 0.5]), np.ones(2, bool)
    for evidence in [[0.0, -1e9]] * 30 + [[-1e9, 0.0]] * 2:
        belief = filtered(predicted(belief, enabled, 0.01), np.array(evidence))
    assert belief[1] > 0.999


def by_enumeration(log_likelihood: Array, h: float) -> Array:
    """Return the posterior by a sum over all paths of states."""
    steps, states = log_likelihood.shape
    posterior = np.zeros((steps, states))
    for path in itertools.product(range(states), repeat=steps):
        weight = np.exp(log_likelihood[0, path[0]]) / states
        for t in range(1, steps):
            stay = (1 - h) * (path[t] == path[t - 1]) + h / states
            weight *= stay * np.exp(log_likelihood[t, path[t]])
        posterior[np.arange(steps), path] += weight
    return posterior / posterior.sum(axis=1, keepdims=True)


@given(st.integers(1, 5), st.integers(1, 3), probabilities, st.integers(0, 99))
def test_the_smoothed_belief_is_that_of_all_paths(
    steps: int, states: int, h: float, seed: int
) -> None:
    evidence = np.random.default_rng(seed).normal(0.0, 2.0, (steps, states))
    found = smoothed(evidence, h)
    np.testing.assert_allclose(found, by_enumeration(evidence, h), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.sum(axis=1), 1.0)


@given(st.integers(2, 6), st.integers(2, 4), probabilities, st.integers(0, 99))
def test_the_last_smoothed_belief_is_the_filtered_one(
    steps: int, states: int, h: float, seed: int
) -> None:
    evidence = np.random.default_rng(seed).normal(0.0, 2.0, (steps, states))
    belief = np.full(states, 1 / states)
    for row in evidence:
        belief = filtered(predicted(belief, np.ones(states, bool), h), row)
    np.testing.assert_allclose(smoothed(evidence, h)[-1], belief, rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_time_reversed_episode_has_the_reversed_posterior(seed: int) -> None:
    evidence = np.random.default_rng(seed).normal(0.0, 3.0, (40, 3))
    np.testing.assert_allclose(smoothed(evidence[::-1], 0.05), smoothed(evidence, 0.05)[::-1])


def test_one_state_is_certain() -> None:
    np.testing.assert_array_equal(smoothed(np.full((7, 1), -1e300), 0.03), np.ones((7, 1)))
    one = np.ones(1)
    np.testing.assert_array_equal(filtered(one, np.array([-1e300])), one)
    np.testing.assert_array_equal(predicted(one, np.ones(1, bool), 0.03), one)


def test_without_memory_only_the_evidence_of_the_step_counts() -> None:
    evidence = np.random.default_rng(0).normal(size=(9, 3))
    alone = np.exp(evidence) / np.exp(evidence).sum(axis=1, keepdims=True)
    np.testing.assert_allclose(smoothed(evidence, 1.0), alone)
    belief = predicted(np.array([1.0, 0.0, 0.0]), np.ones(3, bool), 1.0)
    np.testing.assert_allclose(filtered(belief, evidence[0]), alone[0])


def test_at_the_largest_switching_probability_half_of_a_belief_is_kept_each_step() -> None:
    enabled = np.ones(2, bool)
    belief = np.array([1.0, 0.0])
    for step in range(1, 9):
        belief = predicted(belief, enabled, 0.5)
        np.testing.assert_allclose(belief - 0.5, np.array([0.5, -0.5]) * 0.5**step)


def test_evidence_of_thousands_of_steps_does_not_underflow() -> None:
    evidence = np.zeros((5000, 2))
    evidence[:2500, 1] = evidence[2500:, 0] = -400.0
    found = smoothed(evidence, 1e-3)
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(found.argmax(axis=1), np.repeat([0, 1], 2500))
