"""The gate in two levels: equations, masks, and plants that only some runs of a batch have."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpma_mj import MPMAConfig
from mpma_mj.agents import AgentSpec
from mpma_mj.agents.networks import NetworkFactory
from mpma_mj.agents.plant_gate import PlantGate
from mpma_mj.agents.plant_models import gaussian_log_likelihood, plant_inputs
from mpma_mj.agents.switching import filtered, predicted

Array = np.ndarray
State = dict[str, Array]

LABELS, MODULES = 4, 3
SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)
SPEC = AgentSpec(LABELS, SPEED, 0.05)
H = 0.03


def made(plants: int = 2, most: int = 3, modules: int = MODULES, **config: Any) -> PlantGate:
    """Return a gate that has recruited some plants, whose models differ."""
    settings = MPMAConfig(nodes=5, modules=modules, max_plants=most, **config)
    gate = PlantGate(NetworkFactory(settings, 0, modules, max_plants=most), settings, SPEC)
    rng = np.random.default_rng(0)
    gate.models.recruited[...] = plants
    gate.models.epochs[...] = 5
    gate.models.weights[...] = rng.normal(0.0, 0.3, gate.models.weights.shape)
    gate._preferences[...] = rng.uniform(0.05, 1.0, gate._preferences.shape)
    gate.reset(0)
    return gate


def observed(t: int, label: int = 0) -> dict[str, Array]:
    rng = np.random.default_rng(t)
    return {
        "context": np.eye(LABELS)[label],
        "joint_angles": 0.1 * rng.normal(size=8),
        "joint_velocities": rng.normal(size=8),
    }


def state_of(seen: dict[str, Array]) -> Array:
    """Return the proprioceptive state of an observation, of which the posture does not count."""
    angles, relative = seen["joint_angles"], seen["joint_velocities"] / SPEED
    return np.concatenate([np.full(12, np.nan), np.sin(angles), np.cos(angles), relative])


def steps(gate: PlantGate, count: int = 12, off: float = 0.1) -> list[tuple[Array, Array]]:
    """Return priors and responsibilities of an episode with random predictions."""
    rng, found, predictions = np.random.default_rng(1), [], None
    gate.reset(1)
    for t in range(count):
        seen = observed(t, t % LABELS)
        found.append(gate(seen, predictions))
        gate.observe_action(seen["joint_angles"], state_of(seen), rng.uniform(-1, 1, 8))
        predictions = rng.normal(0.0, off, (gate.plants * gate._modules, 8))
    return found


@pytest.fixture(scope="module")
def gates() -> dict[int, PlantGate]:
    return {plants: made(plants) for plants in (1, 2, 3)}


@given(plants=st.integers(1, 3), mask=arrays(bool, 9), temperature=st.sampled_from([0.0, 0.1, 1.0]))
def test_responsibilities_sum_to_1_over_the_modules_that_are_enabled(
    gates: dict[int, PlantGate], plants: int, mask: Array, temperature: float
) -> None:
    gate = gates[plants]
    object.__setattr__(gate._config, "temperature", temperature)
    gate.enabled[:] = mask
    present = mask[: plants * MODULES]
    for prior, responsibility in steps(gate, 6):
        for shares in (prior, responsibility):
            assert shares.shape == (plants * MODULES,)
            assert (shares >= 0.0).all()
            assert not shares[~present].any()
            assert shares.sum() == pytest.approx(1.0 if present.any() else 0.0)


def test_responsibility_is_belief_in_a_plant_times_share_inside_it() -> None:
    gate, rng = made(plants=2, temperature=0.4), np.random.default_rng(3)
    gate._variance[...] = rng.uniform(0.01, 0.1, gate._variance.shape)
    gate.models.variance[...] = rng.uniform(0.5, 2.0, gate.models.variance.shape)
    belief, last, predictions = np.full(2, 0.5), None, None
    for t in range(10):
        seen = observed(t, t % LABELS)
        prior, responsibility = gate(seen, predictions)
        before = predicted(belief, np.ones(2, bool), H)
        inside = prior.reshape(2, MODULES) / before[:, None]
        np.testing.assert_allclose(inside.sum(axis=1), 1.0)
        belief = before
        if last is not None:
            move = SPEC.move(last[0]["joint_angles"], seen["joint_angles"])
            inputs = plant_inputs(last[1], state_of(last[0]))
            errors = gate.models.weights[:2] @ inputs - move
            logs = gaussian_log_likelihood(errors, gate.models.variance[:2])
            belief = filtered(before, logs)
            likely = gaussian_log_likelihood(predictions - move, gate._variance[:6], 9.0)
            inside = inside * np.exp(0.4 * likely.reshape(2, MODULES))
            inside /= inside.sum(axis=1, keepdims=True)
        expected = (belief[:, None] * inside).ravel()
        np.testing.assert_allclose(responsibility, expected, rtol=1e-9, atol=1e-15)
        last = seen, rng.uniform(-1, 1, 8)
        gate.observe_action(seen["joint_angles"], state_of(seen), last[1])
        predictions = rng.normal(0.0, 0.2, (6, 8))


def test_priors_are_the_preferences_for_the_label() -> None:
    gate = made(plants=2)
    for t in range(8):
        label = t % LABELS
        prior, _ = gate(observed(t, label), None)
        share = np.clip(gate._preferences[:2, label], 0.01, 1.0)
        share /= share.sum(axis=1, keepdims=True)
        # Untrained decoders return the context itself.
        np.testing.assert_allclose(prior, (0.5 * share).ravel(), rtol=1e-6)


def test_with_one_plant_the_belief_is_1() -> None:
    gate = made(plants=1)
    for prior, responsibility in steps(gate):
        assert prior.sum() == pytest.approx(1.0, abs=1e-12)
        assert responsibility.sum() == pytest.approx(1.0, abs=1e-12)
        np.testing.assert_allclose(gate._belief, 1.0, atol=1e-15)


@pytest.mark.parametrize("plants", [1, 3])
def test_without_temperature_the_context_alone_divides_a_plant(plants: int) -> None:
    for prior, responsibility in steps(made(plants=plants, temperature=0.0)):
        share, prior_share = (
            shares.reshape(plants, MODULES) / shares.reshape(plants, MODULES).sum(1, keepdims=True)
            for shares in (responsibility, prior)
        )
        np.testing.assert_allclose(share, prior_share, rtol=1e-12)


def test_predictions_that_are_all_far_off_leave_the_prior() -> None:
    gate = made(plants=1, temperature=1.0)
    for prior, responsibility in steps(gate, off=1e4):
        np.testing.assert_allclose(responsibility, prior, rtol=1e-12)
    near = steps(gate, off=0.5)
    assert max(np.abs(r - p).max() for p, r in near[1:]) > 0.01


def test_before_the_first_epoch_predictions_do_not_count() -> None:
    gate = made(plants=1, temperature=1.0)
    gate.models.epochs[...] = 0
    for prior, responsibility in steps(gate):
        np.testing.assert_array_equal(responsibility, prior)


def test_without_forward_gating_a_belief_is_never_changed() -> None:
    for prior, responsibility in steps(made(plants=2, forward_gating=False)):
        np.testing.assert_array_equal(responsibility, prior)
        np.testing.assert_allclose(prior.reshape(2, -1).sum(axis=1), 0.5)


def test_without_predictors_modules_of_a_plant_are_alike() -> None:
    gate = made(plants=2, responsibility_predictors=False)
    gate.enabled[1] = False
    for prior, _ in steps(gate, 2):
        np.testing.assert_allclose(prior[:3], [0.25, 0.0, 0.25])
        np.testing.assert_allclose(prior[3:6], 0.5 / 3)


def test_a_plant_whose_modules_are_off_is_not_believed_in() -> None:
    gate = made(plants=3)
    gate.enabled[3:6] = False
    for prior, responsibility in steps(gate):
        for shares in (prior, responsibility):
            by_plant = shares.reshape(3, MODULES).sum(axis=1)
            assert by_plant[1] == 0.0
            assert by_plant.sum() == pytest.approx(1.0)


def test_a_new_plant_inherits_the_preferences_of_the_plant_that_was_taken_for_it() -> None:
    gate = made(plants=2)
    gate._visits[:2] = [[4.0] * LABELS, [10.0] * LABELS]
    posterior = np.zeros((20, 3))
    posterior[:5, 0], posterior[5:12, 1], posterior[12:, 2] = 1.0, 1.0, 1.0
    before = gate._preferences.copy()
    gate._inherit((), posterior, 2)
    np.testing.assert_array_equal(gate._preferences[2], before[1])
    np.testing.assert_array_equal(gate._preferences[:2], before[:2])
    np.testing.assert_allclose(gate._visits[2], 1.0)


@pytest.mark.parametrize("plants", [0, 4])
def test_a_state_of_fewer_plants_than_one_or_more_than_the_most_is_refused(plants: int) -> None:
    state = made(plants=2, most=3).state_dict()
    state["plants.recruited"][...] = plants
    with pytest.raises(ValueError, match="not one from 1 to 3"):
        made(plants=2, most=3).load_state_dict(state)
