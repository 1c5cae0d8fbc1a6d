"""State models of an artificial linear arm, of which everything is known."""

import numpy as np
import pytest

from mpma_mj.agents.base import AgentSpec
from mpma_mj.agents.state_models import StateModels, kinematic_prior, state_inputs

Array = np.ndarray

SPEC = AgentSpec(4, np.array([12.0, 12.0, 20.0, 15.0] * 2), 0.05)
REACH = SPEC.control_timestep * SPEC.max_joint_speed
STEPS = 300


def arm(seed: int) -> Array:
    """Return A of an arm, shape (16, 33), that mostly moves as it is commanded."""
    return kinematic_prior() + 0.05 * np.random.default_rng(seed).normal(size=(16, 33))


def episode(model: Array, seed: int, steps: int = STEPS) -> dict[str, Array]:
    """Return steps from anywhere in the space of states, as `Senses.aligned` returns them."""
    rng = np.random.default_rng(seed)
    action, speed = rng.uniform(-1, 1, (2, steps, 8))
    angles = rng.uniform(-2, 2, (steps, 8))
    outputs = state_inputs(action, angles, speed) @ model.T
    return {
        "action": action,
        "joint_angles": angles,
        "joint_velocities": speed * SPEC.max_joint_speed,
        "next_joint_angles": angles + REACH * outputs[:, :8],
        "next_joint_velocities": outputs[:, 8:] * SPEC.max_joint_speed,
    }


def shares(plant: int = 0, steps: int = STEPS, plants: int = 2) -> Array:
    return np.tile(np.eye(plants)[plant], (steps, 1))


def test_without_steps_joints_move_as_commanded() -> None:
    models = StateModels(SPEC, (3,), 2)
    rng = np.random.default_rng(0)
    command, angles, speed = rng.uniform(-1, 1, (3, 3, 8))
    angles_after, speed_after = models.following(
        models.of_plant(np.array([0, 1, 0])), command, angles, speed
    )
    np.testing.assert_allclose(angles_after, angles + REACH * command)
    np.testing.assert_allclose(speed_after, command)


def test_an_exactly_linear_arm_is_recovered_up_to_the_ridge() -> None:
    models, true = StateModels(SPEC, (), 2), arm(1)
    steps = episode(true, 0)
    error = models.learn(steps, shares(), ())
    inputs = state_inputs(
        steps["action"], steps["joint_angles"], steps["joint_velocities"] / SPEC.max_joint_speed
    )
    gram = inputs.T @ inputs
    ridge = 1e-3 * STEPS * np.eye(33)
    bias = np.linalg.solve(gram + ridge, ridge @ (kinematic_prior() - true).T).T
    np.testing.assert_allclose(models.of_plant(0), true + bias, atol=1e-12)
    assert np.abs(bias).max() < 0.02
    assert error.max() < (0.02 * REACH.max()) ** 2
    np.testing.assert_array_equal(models.variance, 2e-4)  # the least


def test_an_arm_that_moves_as_commanded_keeps_the_prior() -> None:
    models = StateModels(SPEC, (), 1)
    models.learn(episode(kinematic_prior(), 0), shares(plants=1), ())
    np.testing.assert_allclose(models.of_plant(0), kinematic_prior(), atol=1e-12)


def test_later_epochs_count_more() -> None:
    models = StateModels(SPEC, (), 1)
    for _ in range(8):
        models.learn(episode(arm(1), 0), shares(plants=1), ())
    models.learn(episode(arm(2), 1), shares(plants=1), ())
    forgotten = 0.7 * (1 - 0.7**8) / 0.3  # weight of the first arm's epochs
    share = 1.0 / (1.0 + forgotten)
    expected = share * arm(2) + (1 - share) * arm(1)
    assert np.abs(models.of_plant(0) - expected).mean() < 0.2 * np.abs(arm(2) - arm(1)).mean()


def test_a_plant_with_few_steps_keeps_its_model() -> None:
    models = StateModels(SPEC, (), 2)
    models.learn(episode(arm(1), 0), shares(0), ())
    models.learn(episode(arm(2), 1), shares(1), ())
    before = models.of_plant(0).copy(), models.of_plant(1).copy()
    mixed = shares(1)
    mixed[:20] = [1.0, 0.0]
    models.learn(episode(arm(2), 2), mixed, ())
    np.testing.assert_array_equal(models.of_plant(0), before[0])
    assert np.abs(models.of_plant(1) - before[1]).max() > 0.0


def test_each_plant_learns_its_own_arm_and_the_error_is_that_of_the_best() -> None:
    models = StateModels(SPEC, (), 3)
    arms = arm(1), arm(2)
    for seed in range(3):
        for plant, true in enumerate(arms):
            error = models.learn(episode(true, seed), shares(plant), ())
            assert error.shape == (8,)
            assert error.max() < (0.02 * REACH.max()) ** 2
    for plant, true in enumerate(arms):
        np.testing.assert_allclose(models.of_plant(plant), true, atol=0.02)


def observe(models: StateModels, true: Array, seed: int, steps: int = STEPS) -> tuple[Array, Array]:
    """Let models take up steps of an arm; return their inputs and outputs."""
    rng = np.random.default_rng(seed)
    inputs = state_inputs(*rng.uniform(-1, 1, (3, steps, 8)))
    outputs = inputs @ true.T
    for o, y in zip(inputs, outputs, strict=True):
        models.observe(o, y, np.array(True))
    return inputs, outputs


def test_the_steps_of_an_episode_are_added_to_what_was_learned() -> None:
    models = StateModels(SPEC, (), 2)
    models.learn(episode(arm(1), 0), shares(), ())
    learned, gram = models.of_plant(0), models.state_dict()["state_models.gram"][0]
    inputs, outputs = observe(models, arm(2), 1)
    rest = inputs.T @ (outputs - inputs @ learned.T)
    change = np.linalg.solve(gram + inputs.T @ inputs + 10.0 * np.eye(33), rest).T
    np.testing.assert_allclose(models.of_plant(0), learned + change, atol=1e-12)


def test_an_episode_changes_a_plant_never_met_more_than_one_that_was_learned() -> None:
    models = StateModels(SPEC, (), 2)
    for seed in range(5):
        models.learn(episode(arm(1), seed), shares(), ())
    before = models.of_plant(0), models.of_plant(1)
    observe(models, arm(2), 9, 60)
    changes = [np.abs(models.of_plant(w) - before[w]).mean() for w in (0, 1)]
    assert changes[0] < 0.5 * changes[1]
    errors = [np.abs(model - arm(2)).mean() for model in (before[1], models.of_plant(1))]
    assert errors[1] < 0.7 * errors[0]


def test_an_episode_of_the_arm_that_was_learned_brings_its_model_no_further_off() -> None:
    models, true = StateModels(SPEC, (), 1), arm(1)
    models.learn(episode(true, 0), shares(plants=1), ())
    before = np.abs(models.of_plant(0) - true).mean()
    observe(models, true, 1)
    assert np.abs(models.of_plant(0) - true).mean() <= before


def test_steps_on_which_no_command_acted_and_earlier_episodes_do_not_count() -> None:
    models = StateModels(SPEC, (2,), 1)
    models.observe(np.ones((2, 33)), np.zeros((2, 16)), np.array([True, False]))
    adapted = models.of_plant(np.zeros(2, int))
    np.testing.assert_array_equal(adapted[1], kinematic_prior())
    assert np.abs(adapted[0] - kinematic_prior()).max() > 0.0
    models.reset()
    np.testing.assert_array_equal(models.of_plant(np.zeros(2, int))[0], kinematic_prior())


def test_widths_are_twice_the_median_squared_error_of_moves() -> None:
    models, rng = StateModels(SPEC, (), 1), np.random.default_rng(3)
    steps = episode(arm(1), 0, 3000)
    noise = rng.normal(size=(3000, 8)) * 0.1
    steps["next_joint_angles"] = steps["next_joint_angles"] + REACH * noise
    models.learn(steps, shares(steps=3000, plants=1), ())
    np.testing.assert_allclose(models.variance, 2.0 * 0.4549 * 0.01, rtol=0.1)


def test_a_run_of_a_batch_learns_as_alone_and_leaves_the_others() -> None:
    batch, alone = StateModels(SPEC, (3,), 2), StateModels(SPEC, (), 2)
    batch.learn(episode(arm(1), 0), shares(), (1,))
    alone.learn(episode(arm(1), 0), shares(), ())
    for name, array in alone.state_dict().items():
        np.testing.assert_array_equal(batch.state_dict()[name][1], array)
    for run in (0, 2):
        prior = batch.state_dict()["state_models.weights"][run]
        np.testing.assert_array_equal(prior, np.tile(kinematic_prior(), (2, 1, 1)))


def test_a_state_dict_round_trip_continues_to_the_bit() -> None:
    models, other = StateModels(SPEC, (), 2), StateModels(SPEC, (), 2)
    models.learn(episode(arm(1), 0), shares(), ())
    state = models.state_dict()
    models.learn(episode(arm(2), 1), shares(), ())
    assert any((state[name] != array).any() for name, array in models.state_dict().items())
    other.load_state_dict(state | {"another": np.zeros(3)})
    other.learn(episode(arm(2), 1), shares(), ())
    for name, array in models.state_dict().items():
        np.testing.assert_array_equal(other.state_dict()[name], array)
    with pytest.raises(KeyError, match=r"state_models\.gram"):
        other.load_state_dict({"state_models.weights": state["state_models.weights"]})


def test_selected_runs_keep_their_models() -> None:
    models = StateModels(SPEC, (3,), 2)
    for run in range(3):
        models.learn(episode(arm(run), run), shares(), (run,))
    before = models.state_dict()
    models.select_runs(np.array([2, 0]))
    for name, array in models.state_dict().items():
        np.testing.assert_array_equal(array, before[name][[2, 0]])
