"""Spaces of the models, compared with the equations."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.agents import AgentSpec, HAMMERConfig, MOSAICConfig, MPMAConfig
from mpma_mj.agents.model_space import JointSpace, PostureSpace, model_space, module_action
from mpma_mj.kinematics import posture_from_angles

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)
SPEC = AgentSpec(4, SPEED, 0.05)
T = 50

Array = np.ndarray


def angles(seed: int = 0, steps: int = T) -> Array:
    """Return joint angles far from singular poses, shape (T, 8)."""
    rng = np.random.default_rng(seed)
    arm = rng.uniform([0.3, 0.3, -0.8, 0.6], [1.2, 1.0, 0.8, 1.8], (2, steps, 4))
    return np.concatenate([*arm], axis=1)


def observation(seed: int = 0) -> dict[str, Array]:
    q = angles(seed)
    velocities = np.random.default_rng(seed).normal(size=q.shape)
    return {
        "posture": posture_from_angles(q),
        "joint_angles": q,
        "joint_velocities": velocities,
        "reference": posture_from_angles(angles(seed + 1)),
        "target": posture_from_angles(angles(seed + 2)),
    }


@pytest.mark.parametrize("history", [False, True])
def test_joint_states_and_inputs_have_the_stated_parts_and_sizes(history: bool) -> None:
    space, seen = JointSpace(SPEC, history=history), observation()
    q, target = seen["joint_angles"], seen["target"]
    before, action = q - 0.1, np.random.default_rng(2).uniform(-1, 1, q.shape)
    parts = [seen["posture"], np.sin(q), np.cos(q), seen["joint_velocities"] / SPEED]
    if history:
        parts += [np.full(q.shape, 0.1) / (0.05 * SPEED), action]
    state = space.state(seen, (before, action))
    np.testing.assert_allclose(state, np.concatenate(parts, axis=1), atol=1e-14)
    assert state.shape == (T, space.state_size) == (T, 52 if history else 36)
    first = space.state(seen, None)
    np.testing.assert_array_equal(first[:, :36], state[:, :36])
    assert not first[:, 36:].any()
    feedback, command = space.commands(seen)
    np.testing.assert_array_equal(feedback, SPEC.feedback(q, seen["reference"]))
    np.testing.assert_array_equal(command, SPEC.feedback(q, target))
    inputs = space.inverse_input(state, target, command)
    np.testing.assert_array_equal(inputs, np.concatenate([state, target, command], axis=1))
    assert inputs.shape == (T, space.inverse_inputs)
    assert space.outputs == 8


@pytest.mark.parametrize("proprioception", [True, False])
def test_posture_states_and_inputs_have_the_stated_parts_and_sizes(proprioception: bool) -> None:
    space, seen = PostureSpace(SPEC, proprioception=proprioception), observation()
    q, target = seen["joint_angles"], seen["target"]
    parts = [seen["posture"], np.sin(q), np.cos(q)][: 3 if proprioception else 1]
    state = space.state(seen, (q, q))
    np.testing.assert_array_equal(state, np.concatenate(parts, axis=1))
    feedback, command = space.commands(seen)
    np.testing.assert_array_equal(feedback, SPEC.feedback(q, seen["reference"]))
    assert command is None
    inputs = space.inverse_input(state, target, command)
    np.testing.assert_array_equal(inputs, np.concatenate([state, target], axis=1))
    assert inputs.shape == (T, space.inverse_inputs)
    assert state.shape == (T, space.state_size)
    outputs = np.random.default_rng(0).normal(size=(T, 3, 12))
    assert space.predicted_posture(outputs, q) is outputs
    assert space.outcome(q, q, target) is target


def test_a_predicted_posture_is_the_forward_kinematics_of_the_predicted_move() -> None:
    space, q = JointSpace(SPEC), angles()
    moves = np.random.default_rng(0).uniform(-1, 1, (T, 3, 8))
    predicted = space.predicted_posture(moves, q)
    assert predicted.shape == (T, 3, 12)
    for module in range(3):
        after = q + 0.05 * SPEED * moves[:, module]
        np.testing.assert_allclose(predicted[:, module], posture_from_angles(after), atol=1e-14)
    exact = space.outcome(q, angles(1), posture_from_angles(angles(1)))
    reached = space.predicted_posture(exact[:, None], q)[:, 0]
    np.testing.assert_allclose(reached, posture_from_angles(angles(1)), atol=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.integers(-2, 2), st.integers(-2, 2))
def test_a_move_is_the_shorter_way_round(start: float, way: float, turns: int, more: int) -> None:
    space = JointSpace(SPEC)
    before = np.full(8, start + 2 * np.pi * turns)
    after = np.full(8, start + way + 2 * np.pi * more)
    move = space.outcome(before, after, np.zeros(12))
    np.testing.assert_allclose(move, way / (0.05 * SPEED), atol=1e-12)


def arrived(action: Array, gain: float = 1.0) -> tuple[Array, Array]:
    """Return joint angles from which arms of a gain reach poses of weight 1, and their postures.

    There flexion is 0 and the elbow is at a right angle; see `joint_error`.
    """
    q = angles()
    q[:, 1::4], q[:, 3::4] = 0.0, np.pi / 2
    return q - gain * 0.05 * SPEED * action, posture_from_angles(q)


def hindsight(q: Array, action: Array, reached: Array) -> tuple[Array, Array, Array]:
    space = JointSpace(SPEC)
    seen = {"posture": posture_from_angles(q), "joint_angles": q, "joint_velocities": 0.0 * q}
    steps = {**seen, "state": space.state(seen, None), "action": action, "next_posture": reached}
    return space.hindsight(steps, by_angles=False)


def test_hindsight_residuals_are_0_for_the_resolved_rate_command_that_reached_the_posture() -> None:
    action = np.random.default_rng(0).uniform(-0.5, 0.5, (T, 8))
    q, reached = arrived(action)
    np.testing.assert_allclose(SPEC.feedback(q, reached), action, atol=1e-9)
    inputs, residual, usable = hindsight(q, action, reached)
    np.testing.assert_allclose(residual, 0.0, atol=1e-9)
    assert usable.all()
    np.testing.assert_array_equal(inputs[:, 36:48], reached)
    np.testing.assert_array_equal(inputs[:, 48:], SPEC.feedback(q, reached))


def test_hindsight_residuals_of_a_half_gain_are_half_of_the_action() -> None:
    action = np.random.default_rng(0).uniform(-0.9, 0.9, (T, 8))
    q, reached = arrived(action, gain=0.5)
    _, residual, _ = hindsight(q, action, reached)
    np.testing.assert_allclose(residual, 0.5 * action, atol=1e-9)


def test_hindsight_is_the_inverse_of_the_module_action() -> None:
    rng, q = np.random.default_rng(0), angles()
    reached = posture_from_angles(q + 0.05 * SPEED * rng.uniform(-1, 1, q.shape))
    action = np.clip(SPEC.feedback(q, reached) + rng.uniform(-0.9, 0.9, q.shape), -1, 1)
    inputs, residual, usable = hindsight(q, action, reached)
    assert np.abs(residual).max() > 0.8
    again = module_action(residual[:, None], inputs[:, 48:])[:, 0]
    np.testing.assert_allclose(again, action, atol=1e-14)
    np.testing.assert_array_equal(usable, (np.abs(residual) < 0.7).all(axis=1))


def test_hindsight_of_followed_joint_angles_needs_no_weights() -> None:
    q = angles()
    q[:, 1::4] = np.pi / 2 - 0.01  # near straight forward, where a posture hardly shows abduction
    action = np.random.default_rng(0).uniform(-0.5, 0.5, q.shape)
    after = q + 0.05 * SPEED * action
    space, seen = JointSpace(SPEC), observation()
    steps = {"joint_angles": q, "state": space.state(seen, None), "action": action}
    steps |= {"next_posture": posture_from_angles(after), "next_joint_angles": after}
    _, residual, _ = space.hindsight(steps, by_angles=True)
    np.testing.assert_allclose(residual, 0.0, atol=1e-9)
    _, residual, _ = space.hindsight(steps, by_angles=False)
    assert np.abs(residual[:, 0::4]).max() > 0.1


def test_impossible_examples_are_left_out() -> None:
    space, seen = JointSpace(SPEC), observation()
    q = seen["joint_angles"]
    command = SPEC.feedback(q, seen["posture"])  # 0: nothing moves
    action = command.copy()
    action[3, 2], action[5, 7], action[7, 0] = 0.8, -0.7, 0.69
    steps = {"joint_angles": q, "state": space.state(seen, None), "action": action}
    steps["next_posture"] = seen["posture"]
    _, _, usable = space.hindsight(steps, by_angles=False)
    assert np.flatnonzero(~usable).tolist() == [3, 5]


def test_module_actions_are_bounded_outputs_or_bounded_residuals() -> None:
    outputs = np.array([[0.5, -3.0], [0.2, 0.1]])
    np.testing.assert_array_equal(module_action(outputs, None), [[0.5, -1.0], [0.2, 0.1]])
    command = np.array([0.7, 0.4])
    np.testing.assert_allclose(module_action(outputs, command), [[1.0, -0.6], [0.9, 0.5]])


@pytest.mark.parametrize("config_type", [MPMAConfig, MOSAICConfig, HAMMERConfig])
def test_a_config_names_its_space(config_type: Any) -> None:
    plain, longer = (model_space(config_type(history=long), SPEC) for long in (False, True))
    assert isinstance(plain, JointSpace)
    assert longer.state_size == plain.state_size + 16
    posture = {"models": "posture"} | ({"rule": "gated"} if config_type is MPMAConfig else {})
    sensing, blind = (
        model_space(config_type(**posture, proprioception=sensed), SPEC) for sensed in (True, False)
    )
    assert isinstance(sensing, PostureSpace)
    assert (sensing.state_size, blind.state_size) == (28, 12)
