import dataclasses
import itertools
from typing import Any

import dm_env
import numpy as np
import pytest

import mpma_mj
from mpma_mj.agents import MPMA, Agent, AgentSpec, MPMAConfig
from mpma_mj.agents.learning_rules import GatedRule
from mpma_mj.agents.signals import ModuleSignals
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import PRECISION
from mpma_mj.feedback import feedback_action

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)


def agent(seed: int = 0, **config: Any) -> MPMA:
    settings = MPMAConfig(**({"nodes": 20, "modules": 3} | config))
    return MPMA(settings, AgentSpec(4, SPEED, 0.05), seed=seed)


def dance(player: MPMA, epochs: int = 1, seed: int = 0) -> np.ndarray:
    """Dance and learn; return the actions of the last epoch, shape (T, 8)."""
    env = load("ymca", arms="kinematic", repeats=1, seed=seed)
    for epoch in range(epochs):
        actions = []
        player.reset(epoch)
        timestep = env.reset()
        while not timestep.last():
            actions.append(player.act(timestep.observation))
            timestep = env.step(actions[-1])
            player.observe(timestep)
        player.learn()
    return np.array(actions)


def signals_of(player: Agent) -> ModuleSignals:
    signals = player.signals().modules
    assert signals is not None
    return signals


def watch(player: MPMA) -> list[dict[str, np.ndarray]]:
    """Dance an episode without learning; return its observations, the last included."""
    env = load("ymca", arms="kinematic", repeats=1)
    player.reset(7)
    timestep = env.reset()
    observations = [timestep.observation]
    while not timestep.last():
        timestep = env.step(player.act(timestep.observation))
        player.observe(timestep)
        observations.append(timestep.observation)
    return observations


def test_untrained_it_is_the_feedback_controller() -> None:
    env = load("ymca", reference_noise=0.05)
    observation = env.reset().observation
    player = agent()
    expected = feedback_action(observation["joint_angles"], observation["reference"], SPEED, 0.05)
    np.testing.assert_allclose(player.act(observation), expected, atol=1e-15)


@pytest.mark.parametrize("rule", ["weighted", "gated"])
@pytest.mark.parametrize("efference_copy", ["total", "module"])
def test_signals_obey_the_equations(rule: str, efference_copy: str) -> None:
    player = agent(rule=rule, efference_copy=efference_copy)
    dance(player, epochs=3)
    gains = player.gains
    actions, feedback = dance(player), player.signals().feedback
    signals = signals_of(player)
    responsibility = signals.responsibility
    np.testing.assert_allclose(responsibility.sum(axis=1), 1.0)
    assert (responsibility >= 0).all()
    assert (signals.prior >= 0.01).all()
    assert (signals.prior <= 1.0).all()
    assert np.abs(signals.module_actions).max() <= 1.0
    mixed = np.einsum("tm,tmj->tj", responsibility, signals.module_actions)
    total = gains.inverse * mixed + feedback
    np.testing.assert_allclose(actions, np.clip(total, -1, 1), atol=1e-14)


@pytest.mark.parametrize("proprioception", [True, False])
@pytest.mark.parametrize("efference_copy", ["total", "module"])
def test_networks_receive_the_inputs_of_the_equations(
    efference_copy: str, proprioception: bool
) -> None:
    player = agent(efference_copy=efference_copy, proprioception=proprioception)
    dance(player, 2)
    observations = watch(player)
    epoch = player._epoch(())
    for t, seen in enumerate(observations[:-1]):
        angles = seen["joint_angles"] if proprioception else np.empty(0)
        sensed = np.concatenate([seen["posture"], np.sin(angles), np.cos(angles)])
        inverse = np.concatenate([sensed, seen["target"]]).astype(PRECISION)
        assert epoch.inverse_features.shape[2] == 20 + len(inverse)
        np.testing.assert_array_equal(epoch.inverse_features[t, 1, -len(inverse) :], inverse)
        np.testing.assert_array_equal(epoch.predictor_features[t, 1, -4:], seen["context"])
        heard = epoch.action[t] if efference_copy == "total" else epoch.module_actions[t, 1]
        forward = np.concatenate([heard, sensed]).astype(PRECISION)
        assert epoch.forward_features.shape[2] == 20 + len(forward)
        np.testing.assert_array_equal(epoch.forward_features[t, 1, -len(forward) :], forward)


def test_targets_are_one_step_later_to_the_last_step() -> None:
    player = agent()
    observations = watch(player)
    epoch = player._epoch(())
    for t, (seen, after) in enumerate(itertools.pairwise(observations)):
        np.testing.assert_array_equal(epoch.next_posture[t], after["posture"])
        for remembered, moment in ((epoch.feedback, seen), (epoch.next_feedback, after)):
            expected = feedback_action(moment["joint_angles"], moment["reference"], SPEED, 0.05)
            np.testing.assert_array_equal(remembered[t], expected)


@pytest.mark.parametrize("rule", ["weighted", "gated"])
def test_responsibility_is_prior_times_likelihood_of_the_last_prediction(rule: str) -> None:
    player = agent(rule=rule)
    dance(player, 2)
    sigma = float(player.state_dict()["sigma"])
    observations = watch(player)
    epoch = player._epoch(())
    first = epoch.prior[0] / epoch.prior[0].sum()
    np.testing.assert_allclose(epoch.responsibility[0], first)
    for t in range(1, len(epoch.prior)):
        error = np.mean((epoch.predictions[t - 1] - observations[t]["posture"]) ** 2, axis=1)
        joint = epoch.prior[t] * np.exp(-(error - error.min()) / (2 * sigma**2))
        np.testing.assert_allclose(epoch.responsibility[t], joint / joint.sum(), rtol=1e-9)
    assert not np.allclose(epoch.responsibility, epoch.prior / epoch.prior.sum(1, keepdims=True))


def test_each_episode_has_its_own_noise() -> None:
    observation = load("ymca").reset().observation
    player = agent()
    features = []
    for episode in (0, 1, 0):
        player.reset(episode)
        player.act(observation)
        features.append(player._inverse.features.copy())
    np.testing.assert_array_equal(features[0], features[2])
    assert not np.array_equal(features[0], features[1])


def test_the_three_banks_are_drawn_apart() -> None:
    player = agent()
    banks = (player._inverse, player._forward, player._gate.predictor)
    drawn = [bank._reservoirs._input_weights.ravel()[:20] for bank in banks]
    for one, other in itertools.combinations(drawn, 2):
        assert not np.array_equal(one, other)


def test_gains_wait_until_forward_models_predict() -> None:
    player = agent(nodes=50)
    dance(player)
    assert player.gains.progress == 0.0  # the first epoch is the yardstick
    dance(player)
    assert player.gains.progress == pytest.approx(0.25)


def test_equal_seeds_give_equal_actions_and_others_do_not() -> None:
    np.testing.assert_array_equal(dance(agent(0), 2), dance(agent(0), 2))
    assert not np.array_equal(dance(agent(0), 2), dance(agent(1), 2))


def test_a_copy_of_the_state_continues_alike() -> None:
    trained, copy = agent(), agent()
    dance(trained, 3)
    copy.load_state_dict(trained.state_dict())
    np.testing.assert_array_equal(dance(trained), dance(copy))
    for name, value in trained.state_dict().items():
        np.testing.assert_array_equal(value, copy.state_dict()[name])


def test_learning_does_not_change_a_state_that_was_returned() -> None:
    player = agent()
    dance(player)
    state = player.state_dict()
    kept = {name: value.copy() for name, value in state.items()}
    dance(player)
    for name, value in kept.items():
        np.testing.assert_array_equal(state[name], value)


def test_a_module_without_responsibility_learns_nothing_under_the_gated_rule() -> None:
    player = agent(rule="gated")
    dance(player)
    epoch = player._epoch(())
    alone = np.zeros_like(epoch.responsibility)
    alone[:, 0] = 1.0
    GatedRule().fit(player._readouts, dataclasses.replace(epoch, responsibility=alone))
    assert np.abs(player._readouts.forward.weights[0]).max() > 0.01
    assert np.abs(player._readouts.forward.weights[1:]).max() < 1e-12


def test_forward_models_learn_what_actions_lead_to() -> None:
    player = agent(modules=1, nodes=50)
    dance(player, 3)
    epoch = player._epoch(())
    error = np.abs(epoch.predictions[:, 0] - epoch.next_posture).mean()
    assert error < 0.03


def test_one_module_is_always_responsible() -> None:
    player = agent(modules=1)
    dance(player, 2)
    np.testing.assert_array_equal(signals_of(player).responsibility, 1.0)


def test_an_agent_needs_no_environment() -> None:
    rng = np.random.default_rng(0)
    unit = np.tile([0.0, 0.6, -0.8], 4)
    observation = {"posture": unit, "reference": unit, "target": unit, "context": np.eye(4)[0]}
    observation |= {"joint_angles": rng.normal(size=8), "joint_velocities": np.zeros(8)}
    player = agent()
    action = player.act(observation)
    player.observe(dm_env.transition(0.0, observation))
    assert action.shape == (8,)
    assert player.learn().keys() == {"gain_feedback", "gain_inverse", "sigma"}


def test_an_agent_needs_an_environment_and_a_seed() -> None:
    with pytest.raises(BadOptionError, match=r"expected what mpma_mj\.load or"):
        mpma_mj.make_agent(None)
    with pytest.raises(BadOptionError, match="config is 3; expected a config of an agent"):
        mpma_mj.make_agent(load("ymca"), 3)  # type: ignore[arg-type]
    with pytest.raises(BadOptionError, match="agent is"):
        mpma_mj.make_agent(load("ymca"), kind=["mpma"])  # type: ignore[arg-type]
    with pytest.raises(BadOptionError, match="seed is -1"):
        mpma_mj.make_agent(load("ymca"), seed=-1)


def test_without_a_reset_signals_cover_all_steps() -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    acting = mpma_mj.make_agent(env, MPMAConfig(nodes=10))
    for episode in (1, 2):
        timestep = env.reset()
        while not timestep.last():
            timestep = env.step(acting.act(timestep.observation))
            acting.observe(timestep)
        assert len(signals_of(acting).prior) == episode * env.task.steps


def test_a_larger_ridge_leaves_smaller_readouts() -> None:
    sizes = []
    for ridge in (1e-4, 1.0):
        player = agent(ridge=ridge)
        dance(player)
        sizes.append(np.linalg.norm(player.state_dict()["inverse.weights"]))
    assert sizes[1] < 0.5 * sizes[0]
