"""The inverse model that adapts at every step."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import load, make_agent, make_vec
from mpma_mj.agents import Adaptive, AdaptiveConfig
from mpma_mj.metrics import posture_error_percent
from mpma_mj.training.rollout import record_epoch

SMALL = AdaptiveConfig(nodes=10, forgetting=0.95, inverse_ridge=0.1)
IDEAL: dict[str, Any] = {"arms": "kinematic", "repeats": 1}


def adaptive(env: Any, config: AdaptiveConfig = SMALL, seed: Any = 0) -> Adaptive:
    agent = make_agent(env, config, kind="adaptive", seed=seed)
    assert isinstance(agent, Adaptive)
    return agent


def p_e(trace: Any) -> float:
    return posture_error_percent(trace.posture, trace.reference)


def test_its_weights_are_those_of_weighted_least_squares_with_forgetting() -> None:
    env = load("ymca", **IDEAL)
    agent = adaptive(env)
    trace = record_epoch(env, agent, 0)
    features = agent._learning._steps.episode()["features"][:, 0].astype(float)
    assert len(features) == len(trace)  # the last step, too
    command = agent.spec.feedback(trace.joint_angles[:-1], trace.posture[1:])
    memory = 0.95 ** np.arange(len(trace))[::-1, None]
    gram = features.T @ (memory * features)
    regular = gram + 0.1 * np.diag(np.diag(gram)) + 1e-4 / 0.05 * np.eye(len(gram))
    moment = features.T @ (memory * (trace.action - command))
    expected = np.linalg.solve(regular, moment)
    np.testing.assert_allclose(agent.state_dict()["weights"], expected, atol=1e-9)


def test_its_features_are_of_the_posture_that_was_reached() -> None:
    env = load("ymca", **IDEAL)
    agent = adaptive(env)
    trace = record_epoch(env, agent, 0)
    acting, learning = (
        network._steps.episode()["inputs"] for network in (agent._acting, agent._learning)
    )
    np.testing.assert_array_equal(acting[:, :36], learning[:, :36])
    np.testing.assert_array_equal(learning[:, 36:48], trace.posture[1:].astype(np.float32))
    assert np.abs(acting[:, 36:48] - learning[:, 36:48]).max() > 0.01


@pytest.mark.parametrize("gain", [1.0, 0.5])
def test_actions_are_bounded_and_signals_add_up(gain: float) -> None:
    env = load("ymca", plants=[{"actuator_gain": gain}], **IDEAL)
    agent = adaptive(env)
    trace = record_epoch(env, agent, 0)
    assert trace.action.shape == (len(trace), 8)
    assert np.abs(trace.action).max() <= 1.0
    assert trace.modules is None
    np.testing.assert_allclose(
        trace.feedback,
        0.14 * agent.spec.feedback(trace.joint_angles[:-1], trace.reference[:-1]),
        atol=1e-14,
    )
    targets = agent._acting._steps.episode()["inputs"][:, 36:48].astype(float)
    command = agent.spec.feedback(trace.joint_angles[:-1], targets)
    total = np.clip(command + trace.learned + trace.feedback, -1, 1)
    np.testing.assert_allclose(trace.action, total, atol=1e-5)  # inputs are single
    assert not trace.learned[0].any()
    assert np.abs(trace.learned).max() > 0.01


def test_a_batch_equals_each_run_alone_to_the_bit() -> None:
    envs = make_vec(2, "ymca", **IDEAL)
    together = adaptive(envs, seed=[3, 5])
    env = load("ymca", seed=1, **IDEAL)
    alone = adaptive(env, seed=5)
    for epoch in range(2):
        trace = record_epoch(envs, together, epoch).of_run(1).to_arrays()
        for name, signal in record_epoch(env, alone, epoch).to_arrays().items():
            np.testing.assert_array_equal(trace[name], signal, err_msg=name)
        logged = together.learn()
        assert {name: value[1] for name, value in logged.items()} == alone.learn()
    for name, value in alone.state_dict().items():
        np.testing.assert_array_equal(together.state_dict()[name][1], value)
    together.select_runs(np.array([1]))
    selected = record_epoch(make_vec(1, "ymca", seed=1, **IDEAL), together, 2).of_run(0)
    np.testing.assert_array_equal(selected.action, record_epoch(env, alone, 2).action)


def test_a_copy_of_the_state_continues_alike_and_the_state_is_a_copy() -> None:
    env = load("ymca", **IDEAL)
    agent, copy = adaptive(env), adaptive(env)
    record_epoch(env, agent, 0)
    state = agent.state_dict()
    kept = {name: value.copy() for name, value in state.items()}
    copy.load_state_dict(state)
    expected = record_epoch(env, agent, 1).action
    np.testing.assert_array_equal(record_epoch(env, copy, 1).action, expected)
    for name, value in kept.items():
        np.testing.assert_array_equal(state[name], value)
        # Epochs are counted by learn().
        assert np.array_equal(agent.state_dict()[name], value) == (name == "epochs")


def test_in_a_plant_of_half_gain_it_is_better_than_the_resolved_rate_in_the_first_epoch() -> None:
    env = load("ymca", plants=[{"actuator_gain": 0.5}], **IDEAL)
    learned = p_e(record_epoch(env, adaptive(env, AdaptiveConfig(nodes=20)), 0))
    usual = p_e(record_epoch(env, make_agent(env, kind="resolved_rate"), 0))
    assert learned < 0.6 * usual


def test_gains_are_final_from_the_start() -> None:
    env = load("ymca", **IDEAL)
    agent = adaptive(env)
    record_epoch(env, agent, 0)
    learned = agent.learn()
    assert learned == {
        "gain_feedback": pytest.approx(0.14),
        "gain_inverse": 1.0,
        "calibrating": 1.0,
    }


def test_it_calibrates_in_its_first_two_epochs_as_joint_models_do() -> None:
    env = load("ymca", **IDEAL)
    agent = adaptive(env)
    found = []
    for epoch in range(3):
        record_epoch(env, agent, epoch)
        found.append(agent.learn()["calibrating"])
    assert found == [1.0, 1.0, 0.0]
