"""Behaviour cloning and DAgger."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import load, make_agent
from mpma_mj.agents import BC, BCConfig, DAgger, DAggerConfig, MPMAConfig
from mpma_mj.agents.cloning import policy_features
from mpma_mj.errors import BadOptionError, StateError
from mpma_mj.metrics import posture_error_percent
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run import imitate
from mpma_mj.training.trainer import train_batch
from tests.agents.batches import IDEAL, assert_batch_equals_alone

FEW = {"bc": BCConfig(expert_episodes=2), "dagger": DAggerConfig(expert_episodes=2)}


def cloned(env: Any, kind: str, seed: Any = 0) -> BC:
    agent = make_agent(env, FEW[kind], seed=seed)
    assert isinstance(agent, BC)
    return agent


@pytest.mark.parametrize(("agent", "most"), [("bc", 1.0), ("dagger", 0.5)])
def test_the_policy_of_twenty_expert_episodes_tracks_ymca_with_physics(
    agent: str, most: float
) -> None:
    config = RunConfig.of(agent=agent)
    (run,) = train_batch([config], read_motions(config), 24)
    assert run["converged"]
    assert run["best_epoch"] == 24
    assert run["p_e_percent"] < most


@pytest.mark.parametrize(("kind", "shown"), [("bc", 2), ("dagger", 1)])
def test_the_expert_acts_until_it_has_shown_enough(kind: str, shown: int) -> None:
    env, other = load("ymca", **IDEAL), load("ymca", **IDEAL)
    agent, expert = cloned(env, kind), make_agent(other, MPMAConfig())
    for epoch in range(6):
        acts = epoch < 3 + shown
        assert agent.expert_acts == acts
        trace, alone = record_epoch(env, agent, epoch), record_epoch(other, expert, epoch)
        assert np.array_equal(trace.action, alone.action) == acts
        logged = agent.learn()
        assert logged == {
            "learner_acts": 0.0 if acts else 1.0,
            "calibrating": 1.0 if epoch < 5 else 0.0,
        }
        if epoch < 3:
            expert.learn()


@pytest.mark.parametrize("kind", FEW)
def test_the_policy_is_the_least_squares_fit_of_the_labels(kind: str) -> None:
    env = load("ymca", **IDEAL)
    agent = cloned(env, kind)
    features, labels = [], []
    for epoch in range(5):
        record_epoch(env, agent, epoch)
        steps = {name: rows.copy() for name, rows in agent._steps.episode().items()}
        agent.learn()
        if epoch >= 3:
            features.append(steps["features"])
            labels.append(steps["label"])
    z, y = np.concatenate(features), np.concatenate(labels)
    gram = z.T @ z
    regular = gram + 5e-5 * np.diag(np.diag(gram)) + 1e-8 * len(z) * np.eye(len(gram))
    expected = np.linalg.solve(regular, z.T @ y).T
    # Weights are stored in single precision.
    np.testing.assert_allclose(agent.state_dict()["policy.weights"][0], expected, atol=1e-5)
    trace = record_epoch(env, agent, 5)
    steps = agent._steps.episode()
    np.testing.assert_allclose(
        trace.action, np.clip(steps["features"] @ expected.T, -1, 1), atol=1e-4
    )


def test_labels_of_dagger_lead_to_the_target_where_the_policy_strays() -> None:
    env = load("ymca", repeats=1)
    expert = make_agent(env, MPMAConfig())
    for epoch in range(3):
        record_epoch(env, expert, epoch)
        expert.learn()
    rng = np.random.default_rng(0)
    expert.reset(3)
    timestep = env.reset()
    off_label, off_command = [], []
    while not timestep.last():
        observation = timestep.observation
        command = expert.spec.feedback(observation["joint_angles"], observation["target"])
        executed = np.clip(command + 0.02 * rng.standard_normal(8), -1, 1)
        label = expert.act(observation, executed=executed)
        timestep = env.step(executed)
        expert.observe(timestep)
        # What was executed is, in hindsight, the right command towards what was reached.
        reached = expert.spec.feedback(observation["joint_angles"], timestep.observation["posture"])
        corrected = expert.spec.feedback(observation["joint_angles"], observation["reference"])
        residual = label - command - 0.14 * corrected
        off_command.append(executed - reached)
        off_label.append(executed - reached - residual)
    # A label contains most of what the plant adds to a resolved-rate command.
    assert np.square(off_label).mean() < 0.5 * np.square(off_command).mean()


def test_forward_models_receive_what_was_executed() -> None:
    env = load("ymca", **IDEAL)
    agents = [make_agent(env, MPMAConfig(nodes=10, modules=2)) for _ in range(3)]
    for agent in agents:
        record_epoch(env, agent, 0)
        agent.learn()
        agent.reset(1)
    observation = env.reset().observation
    own = agents[0].act(observation)
    np.testing.assert_array_equal(agents[1].act(observation, executed=own), own)
    np.testing.assert_array_equal(agents[2].act(observation, executed=-own), own)
    predicted = [agent.predicted_posture() for agent in agents]
    np.testing.assert_array_equal(predicted[0], predicted[1])
    assert np.abs(predicted[0] - predicted[2]).max() > 0.01


@pytest.mark.parametrize("kind", FEW)
def test_a_batch_equals_each_run_alone_to_the_bit(kind: str) -> None:
    assert_batch_equals_alone(lambda env, seed: cloned(env, kind, seed), epochs=6)


@pytest.mark.parametrize("options", [{}, {"lookahead": 3}])
def test_features_are_the_moves_to_what_is_shown(options: dict[str, int]) -> None:
    env = load("ymca", reference_noise=0.0, **options)
    agent = make_agent(env, kind="resolved_rate")
    observation = env.reset().observation
    features = policy_features(observation, agent.spec)
    moves = agent.spec.feedback(observation["joint_angles"], observation["target"])
    np.testing.assert_allclose(np.clip(features[:8], -1, 1), moves)
    assert features.shape == (41 + 8 * max(options.get("lookahead", 1) - 1, 0),)
    assert features[-1] == 1.0
    if options:
        last = agent.spec.feedback(observation["joint_angles"], observation["lookahead"][-1])
        np.testing.assert_allclose(np.clip(features[16:24], -1, 1), last)


def test_learning_without_an_episode_is_refused_after_others() -> None:
    env = load("ymca", **IDEAL)
    agent = cloned(env, "bc")
    for epoch in range(6):
        record_epoch(env, agent, epoch)
        agent.learn()
    agent.reset(6)
    with pytest.raises(StateError, match="before an episode"):
        agent.learn()


def test_too_few_epochs_for_a_policy_are_refused_before_training() -> None:
    with pytest.raises(BadOptionError) as error:
        imitate("ymca", agent="bc", epochs=23)
    assert str(error.value) == "epochs is 23; expected at least 24, as bc has no result before"
    assert imitate("ymca", agent=FEW["dagger"], epochs=6).summary["best_epoch"] == 6


@pytest.mark.parametrize("number", [0, 1001, 2.5])
def test_numbers_of_expert_episodes_out_of_bounds_are_refused(number: Any) -> None:
    with pytest.raises(BadOptionError, match=f"expert_episodes is {number}; expected a whole"):
        BCConfig(expert_episodes=number)


def test_dagger_beats_cloning_of_one_demonstration() -> None:
    p_e = {}
    for name, config in {"bc": BCConfig(expert_episodes=1), "dagger": DAggerConfig()}.items():
        env = load("ymca", repeats=1)
        agent = make_agent(env, config)
        assert isinstance(agent, DAgger) == (name == "dagger")
        for epoch in range(config.least_epochs):
            trace = record_epoch(env, agent, epoch)
            agent.learn()
        p_e[name] = posture_error_percent(trace.posture[1:], trace.reference[1:])
    assert p_e["dagger"] < 0.7 * p_e["bc"]
