import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy import linalg

from mpma_mj import load, make_agent
from mpma_mj.agents import HAMMER, AgentSpec, HAMMERConfig
from mpma_mj.agents.hammer import next_confidence
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import PRECISION
from mpma_mj.training.rollout import record_epoch

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)


both_spaces = pytest.mark.parametrize("models", ["joint", "posture"])


def hammer(pairs: int = 4, models: Any = "joint") -> HAMMER:
    return HAMMER(HAMMERConfig(nodes=20, models=models), AgentSpec(pairs, SPEED, 0.05))


def dance(agent: Any, epochs: int, learn: bool = True) -> Any:
    env = load("ymca", arms="kinematic", repeats=1)
    for epoch in range(epochs):
        trace = record_epoch(env, agent, epoch)
        if learn:
            agent.learn()
    return trace


def test_confidence_grows_where_right_and_falls_where_wrong() -> None:
    confidence = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(next_confidence(confidence, np.array([0.3, 0.1, 0.2])), [0, 3, 2])


def test_confidence_stays_between_0_and_5() -> None:
    confidence = np.zeros(2)
    for _ in range(20):
        confidence = next_confidence(confidence, np.array([0.0, 1.0]))
    np.testing.assert_array_equal(confidence, [5, 0])
    for _ in range(3):
        confidence = next_confidence(confidence, np.array([1.0, 0.0]))
    np.testing.assert_array_equal(confidence, [2, 3])


def test_equally_right_pairs_both_gain() -> None:
    np.testing.assert_array_equal(next_confidence(np.zeros(3), np.zeros(3)), 1.0)


@both_spaces
def test_while_preparing_each_label_has_its_own_pair_and_feedback_leads(models: str) -> None:
    agent = hammer(models=models)
    for _ in range(3):
        assert agent.is_preparing
        trace = dance(agent, 1)
        np.testing.assert_array_equal(trace.modules.responsibility, trace.context[:-1])
        assert agent.gains.progress == 0.0
    assert not agent.is_preparing


@both_spaces
def test_each_pair_learns_by_ridge_regression_from_its_own_label_only(models: str) -> None:
    agent = hammer(models=models)
    trace = dance(agent, 1)
    epoch, features = agent._epoch(()), agent._features(())
    hit = np.clip(trace.action + epoch.next_feedback, -1, 1)
    targets = {"forward": (trace.posture[1:], 0.0), "inverse": (hit, 0.0)}
    if models == "joint":
        angles = agent._own_steps(())["joint_angles"]
        residual = trace.action - agent.spec.feedback(angles, trace.posture[1:])
        blocks = [block.copy() for _, block in features["inverse_features"].blocks()]
        features["inverse_features"] = np.concatenate(blocks)
        targets = {"forward": (epoch.outcome, 0.0), "inverse": (residual, 0.03)}
    for i in range(4):
        own = trace.context[:-1, i] == 1
        assert 0 < own.sum() < len(own)
        for name, (target, relative) in targets.items():
            z = features[f"{name}_features"][own, i].astype(float)
            gram = z.T @ z
            ridge = (1e-6 if relative else 1e-4) * own.sum() * np.eye(z.shape[1])
            ridge += relative * np.diag(np.diag(gram))
            expected = linalg.solve(gram + ridge, z.T @ target[own]).T
            weights = getattr(agent._readouts, name).weights[i]
            # What they say: directions in which features do not vary are found to no digit.
            np.testing.assert_allclose(z @ weights.T, z @ expected.T, atol=1e-4)


def test_inverse_models_learn_from_usable_steps_only() -> None:
    agent = hammer()
    dance(agent, 1, learn=False)
    features = agent._features(()) | {"usable": np.zeros(len(agent._steps), bool)}
    agent._rule.fit(agent._readouts, dataclasses.replace(agent._epoch(()), **features))
    assert agent._readouts.forward.weights.any()
    assert not agent._readouts.inverse.weights.any()


def test_from_steps_without_a_label_no_pair_learns() -> None:
    agent = hammer()
    env = load("ymca", arms="kinematic", repeats=1)
    timestep = env.reset()
    while not timestep.last():
        silent = dict(timestep.observation) | {"context": np.zeros(4)}
        timestep = env.step(agent.act(silent))
        agent.observe(timestep)
    agent.learn()
    assert not agent._readouts.forward.weights.any()
    assert not agent._readouts.inverse.weights.any()


@both_spaces
def test_prepared_pairs_stay_as_they_are_and_control_passes(models: str) -> None:
    agent = hammer(models=models)
    dance(agent, 3)
    before = agent.state_dict()
    dance(agent, 2)
    after = agent.state_dict()
    for name in before.keys() - {"progress", "untrained_error"}:
        np.testing.assert_array_equal(after[name], before[name])
    assert after["progress"] > before["progress"] == 0.0


@both_spaces
def test_the_most_confident_takes_all_by_what_the_demonstrator_did(models: str) -> None:
    agent = hammer(models=models)
    dance(agent, 3)
    trace = dance(agent, 1)
    confidence = np.zeros(4)
    for t, share in enumerate(trace.modules.responsibility):
        if t > 0:
            away = trace.modules.predictions[t - 1] - trace.reference[t]
            confidence = next_confidence(confidence, np.mean(away**2, axis=1))
        expected = np.eye(4)[np.argmax(confidence)]
        np.testing.assert_array_equal(share, expected)
    np.testing.assert_array_equal(trace.modules.prior, trace.modules.responsibility)


@both_spaces
def test_prepared_forward_models_receive_their_own_inverse_models_command(models: str) -> None:
    agent = hammer(models=models)
    for preparing in (True, False):
        assert agent.is_preparing == preparing
        trace = dance(agent, 1, learn=False)
        heard = agent._features(())["forward_features"][:, :, 20:28]
        total = np.repeat(trace.action[:, None], 4, axis=1)
        expected = total if preparing else trace.modules.module_actions
        np.testing.assert_array_equal(heard, expected.astype(PRECISION))
        dance(agent, 3)


def test_the_winner_does_not_depend_on_the_context() -> None:
    agent = hammer()
    dance(agent, 3)
    trace = dance(agent, 1)
    right = (trace.modules.responsibility * trace.context[:-1]).sum(axis=1)
    assert right.mean() > 0.5  # a quarter by chance
    env = load("ymca", arms="kinematic", repeats=1)
    observation = dict(env.reset().observation)
    agent.reset(3)
    heard = agent.act(observation)
    agent.reset(3)
    np.testing.assert_array_equal(agent.act(observation | {"context": np.zeros(4)}), heard)


def test_one_pair_is_always_responsible() -> None:
    agent = hammer(1)
    env = load("ymca", arms="kinematic", repeats=1)
    observation = dict(env.reset().observation) | {"context": np.ones(1)}
    agent.act(observation)
    modules = agent.signals().modules
    assert modules is not None
    np.testing.assert_array_equal(modules.responsibility, [[1.0]])


@both_spaces
@pytest.mark.parametrize("epochs", [1, 4])
def test_a_copy_of_the_state_continues_alike(epochs: int, models: str) -> None:
    trained, copy = hammer(models=models), hammer(models=models)
    dance(trained, epochs)
    copy.load_state_dict(trained.state_dict())
    assert copy.is_preparing == trained.is_preparing
    np.testing.assert_array_equal(dance(trained, 2).action, dance(copy, 2).action)
    for name, value in trained.state_dict().items():
        np.testing.assert_array_equal(value, copy.state_dict()[name])


@both_spaces
def test_on_the_way_it_tracks_better_than_feedback(models: Any) -> None:
    env = load("ymca", arms="kinematic")
    agent = make_agent(env, HAMMERConfig(models=models), kind="hammer")
    errors = []
    for epoch in range(9):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
        errors.append(np.abs(trace.posture - trace.reference).mean())
    alone = record_epoch(env, make_agent(env, kind="feedback_only"), 8)
    usual = np.abs(alone.posture - alone.reference).mean()
    assert min(errors) < 0.6 * usual


@pytest.mark.parametrize("pairs", [2, 6])
def test_there_is_a_pair_for_every_label(pairs: int) -> None:
    observation = load("ymca", arms="kinematic").reset().observation
    with pytest.raises(BadOptionError, match=f"context is .4,.; expected {pairs} labels, one for"):
        hammer(pairs).act(observation)
