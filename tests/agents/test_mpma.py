import dataclasses
import itertools
from types import SimpleNamespace
from typing import Any

import dm_env
import numpy as np
import pytest

import mpma_mj
from mpma_mj.agents import MPMA, Agent, AgentSpec, MPMAConfig
from mpma_mj.agents.base import ModuleSignals
from mpma_mj.agents.gain_schedule import FINAL_GAINS, performance
from mpma_mj.agents.learning_rules import GatedRule
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError
from mpma_mj.esn import PRECISION
from mpma_mj.feedback import feedback_action
from mpma_mj.kinematics import wrap
from mpma_mj.metrics import posture_error_percent

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)
JOINT: dict[str, Any] = {"models": "joint", "rule": "weighted"}
POSTURE: dict[str, Any] = {"models": "posture", "rule": "gated"}


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


@pytest.mark.parametrize(("config", "residual"), [(POSTURE, 0.0), (JOINT, 0.01)])
def test_untrained_it_is_feedback_and_of_joint_models_a_hundredth_of_the_resolved_rate_command(
    config: dict[str, Any], residual: float
) -> None:
    env = load("ymca", reference_noise=0.05)
    observation = env.reset().observation
    player = agent(**config)
    feedback, resolved_rate = (
        feedback_action(observation["joint_angles"], observation[name], SPEED, 0.05)
        for name in ("reference", "target")
    )
    expected = np.clip(feedback + residual * resolved_rate, -1, 1)
    np.testing.assert_allclose(player.act(observation), expected, atol=1e-15)


@pytest.mark.parametrize(
    "config",
    [JOINT, JOINT | {"history": True}, POSTURE, POSTURE | {"efference_copy": "module"}],
)
def test_signals_obey_the_equations(config: dict[str, Any]) -> None:
    player = agent(**config)
    dance(player, epochs=3)
    gains = player.gains
    actions, feedback = dance(player), player.signals().feedback
    signals = signals_of(player)
    responsibility = signals.responsibility
    np.testing.assert_allclose(responsibility.sum(axis=1), 1.0)
    assert (responsibility >= 0).all()
    joint = config["models"] == "joint"
    assert (signals.prior >= (0.01 / 3 if joint else 0.01)).all()
    assert (signals.prior <= 1.0).all()
    if joint:
        np.testing.assert_allclose(signals.prior.sum(axis=1), 1.0)
    assert np.abs(signals.module_actions).max() <= 1.0
    mixed = np.einsum("tm,tmj->tj", responsibility, signals.module_actions)
    total = gains.inverse * mixed + feedback
    np.testing.assert_allclose(actions, np.clip(total, -1, 1), atol=1e-14)
    seen = player._steps.episode()
    base = np.zeros_like(actions)
    if joint:
        base = feedback_action(seen["joint_angles"], targets_of(player), SPEED, 0.05)
    learned = player.signals().learned
    np.testing.assert_allclose(
        learned, gains.inverse * (mixed - base), atol=3e-7
    )  # inputs are single


def targets_of(player: MPMA) -> np.ndarray:
    """Return the targets of the last episode, as joint inverse models received them."""
    return player._inverse._steps.episode()["inputs"][:, -20:-8].astype(float)


def features_of(player: MPMA) -> Any:
    return SimpleNamespace(**vars(player._epoch(())) | player._features(()))


@pytest.mark.parametrize("proprioception", [True, False])
@pytest.mark.parametrize("efference_copy", ["total", "module"])
def test_posture_networks_receive_the_inputs_of_the_equations(
    efference_copy: str, proprioception: bool
) -> None:
    player = agent(efference_copy=efference_copy, proprioception=proprioception, **POSTURE)
    dance(player, 2)
    observations = watch(player)
    epoch = features_of(player)
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


@pytest.mark.parametrize("history", [False, True])
def test_joint_networks_receive_the_inputs_of_the_equations(history: bool) -> None:
    player = agent(history=history)
    dance(player, 2)
    observations = watch(player)
    epoch = features_of(player)
    acting = player._inverse.episode((), 3)
    learning = np.concatenate([block.copy() for _, block in epoch.inverse_features.blocks()])
    for t, (seen, after) in enumerate(itertools.pairwise(observations)):
        angles = seen["joint_angles"]
        state = [seen["posture"], np.sin(angles), np.cos(angles), seen["joint_velocities"] / SPEED]
        if history and t:
            move = wrap(angles - observations[t - 1]["joint_angles"]) / (0.05 * SPEED)
            state += [move, epoch.action[t - 1]]
        elif history:
            state += [np.zeros(8), np.zeros(8)]
        for features, posture in ((acting, seen["target"]), (learning, after["posture"])):
            command = feedback_action(angles, posture, SPEED, 0.05)
            inputs = np.concatenate([*state, posture, command]).astype(PRECISION)
            assert features.shape[2] == 20 + len(inputs)
            np.testing.assert_array_equal(features[t, 1, 20:], inputs)
        np.testing.assert_allclose(epoch.desired[t], epoch.action[t] - command, atol=1e-14)
        forward = np.concatenate([epoch.action[t], *state]).astype(PRECISION)
        np.testing.assert_array_equal(epoch.forward_features[t, 1, 20:], forward)
    # The noise is the episode's own: features differ by their inputs alone.
    same = player._inverse.replay((), player._inverse._steps.episode()["inputs"])
    kept = np.concatenate([block.copy() for _, block in same.blocks()])
    np.testing.assert_array_equal(kept, acting)


@pytest.mark.parametrize("config", [JOINT, POSTURE])
def test_targets_are_one_step_later_to_the_last_step(config: dict[str, Any]) -> None:
    player = agent(**config)
    observations = watch(player)
    epoch = player._epoch(())
    for t, (seen, after) in enumerate(itertools.pairwise(observations)):
        move = wrap(after["joint_angles"] - seen["joint_angles"]) / (0.05 * SPEED)
        outcome = move if config is JOINT else after["posture"]
        np.testing.assert_allclose(epoch.outcome[t], outcome, atol=1e-15)
        for remembered, moment in ((epoch.feedback, seen), (epoch.next_feedback, after)):
            expected = feedback_action(moment["joint_angles"], moment["reference"], SPEED, 0.05)
            np.testing.assert_array_equal(remembered[t], expected)


def test_posture_responsibility_is_prior_times_likelihood_of_the_last_prediction() -> None:
    player = agent(**POSTURE)
    dance(player, 2)
    sigma = GatedRule.sigma
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


@pytest.mark.parametrize("config", [JOINT, POSTURE])
def test_the_three_banks_are_drawn_apart(config: dict[str, Any]) -> None:
    player = agent(**config)
    gate: Any = player._gate
    banks = (player._inverse, player._forward, gate.predictor or gate._predictor)
    drawn = [bank._reservoirs._input_weights.ravel()[:20] for bank in banks]
    for one, other in itertools.combinations(drawn, 2):
        assert not np.array_equal(one, other)


def test_joint_inverse_models_control_after_the_first_epoch() -> None:
    player = agent()
    dance(player)
    assert player.gains == FINAL_GAINS


def test_gains_of_posture_models_wait_until_forward_models_predict() -> None:
    player = agent(nodes=50, **POSTURE)
    dance(player)
    assert player.gains.progress == 0.0  # the first epoch is the yardstick
    untrained = float(player.state_dict()["untrained_error"])
    dance(player)
    epoch = player._epoch(())
    error = posture_error_percent(epoch.mixed(epoch.predictions), epoch.outcome)
    assert 3.0 < error < untrained
    assert player.gains.progress == pytest.approx(0.25 * performance(error, untrained))


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
    player = agent(**POSTURE)
    dance(player)
    epoch = dataclasses.replace(player._epoch(()), **player._features(()))
    alone = np.zeros_like(epoch.responsibility)
    alone[:, 0] = 1.0
    GatedRule().fit(player._readouts, dataclasses.replace(epoch, responsibility=alone))
    assert np.abs(player._readouts.forward.weights[0]).max() > 0.01
    assert np.abs(player._readouts.forward.weights[1:]).max() < 1e-12


@pytest.mark.parametrize(("config", "largest"), [(JOINT, 0.01), (POSTURE, 0.03)])
def test_forward_models_learn_what_actions_lead_to(config: dict[str, Any], largest: float) -> None:
    player = agent(modules=1, nodes=50, **config)
    dance(player, 3)
    epoch = player._epoch(())
    error = np.abs(epoch.predictions[:, 0] - epoch.outcome).mean()
    assert error < largest
    assert error < 0.1 * np.abs(epoch.outcome).mean()


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
    assert player.learn().keys() == {*("gain_feedback", "gain_inverse", "calibrating", "plants")}


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


@pytest.mark.parametrize(
    ("option", "readouts", "config"),
    [
        ("ridge", "forward", JOINT),
        ("inverse_ridge", "inverse", JOINT),
        ("ridge", "inverse", POSTURE),
    ],
)
def test_a_larger_ridge_leaves_smaller_readouts(
    option: str, readouts: str, config: dict[str, Any]
) -> None:
    sizes = []
    for ridge in (1e-4, 1.0):
        player = agent(**config | {option: ridge})
        dance(player)
        sizes.append(np.linalg.norm(player.state_dict()[f"{readouts}.weights"]))
    assert sizes[1] < 0.5 * sizes[0]
