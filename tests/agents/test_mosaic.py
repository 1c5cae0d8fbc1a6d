from typing import Any

import numpy as np
import pytest

from mpma_mj import load, make_agent
from mpma_mj.agents import MOSAIC, AgentSpec, MOSAICConfig
from mpma_mj.agents.gating import likelihood, prediction_errors, responsibilities
from mpma_mj.esn import PRECISION
from mpma_mj.training.rollout import record_epoch

SPEED = np.array([12.0, 12.0, 20.0, 15.0] * 2)


both_spaces = pytest.mark.parametrize("models", ["joint", "posture"])


def mosaic(modules: int = 3, **options: Any) -> MOSAIC:
    return MOSAIC(MOSAICConfig(modules=modules, nodes=20, **options), AgentSpec(4, SPEED, 0.05))


def dance(agent: Any, epochs: int, **options: Any) -> Any:
    env = load("ymca", arms="kinematic", repeats=1, **options)
    for epoch in range(epochs):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
    return trace


@both_spaces
def test_every_step_changes_every_readout_along_its_gated_error(models: str) -> None:
    agent = mosaic(models=models, forward_rate=0.3, inverse_rate=0.4, predictor_rate=0.6)
    dance(agent, 3)
    gain = agent.gains.feedback
    assert gain < 1.0
    env = load("ymca", arms="kinematic", repeats=1, seed=5)
    agent.reset(9)
    timestep = env.reset()
    for _ in range(4):
        before = {n: r.weights.copy() for n, r in vars(agent._readouts).items()}
        angles = timestep.observation["joint_angles"]
        timestep = env.step(agent.act(timestep.observation))
        agent.observe(timestep)
        step = agent._step()
        feedback = agent.spec.feedback(
            timestep.observation["joint_angles"], timestep.observation["reference"]
        )
        outcome = timestep.observation["posture"]
        if models == "joint":
            outcome = agent.spec.move(angles, timestep.observation["joint_angles"])
        for i in range(3):
            share = step.responsibility[i]
            forward, inverse, predictor = (
                getattr(step, f"{n}_features")[i] for n in ("forward", "inverse", "predictor")
            )
            errors = {
                "forward": share * (outcome - step.predictions[i]),
                "inverse": share * gain * feedback,
                "predictor": share - before["predictor"][i] @ predictor,
            }
            features = {"forward": forward, "inverse": inverse, "predictor": predictor}
            for name, rate in {"forward": 0.3, "inverse": 0.4, "predictor": 0.6}.items():
                z = features[name]
                moved = before[name][i] + rate * np.outer(errors[name], z) / (1e-6 + z @ z)
                now = getattr(agent._readouts, name).weights[i]
                np.testing.assert_allclose(now, moved, atol=1e-8)


def test_forward_models_receive_the_total_command() -> None:
    agent = mosaic()
    trace = dance(agent, 3)
    features = agent._features(())["forward_features"]
    heard = features[:, :, 20:][:, :, :8]
    total = np.repeat(trace.action[:, None], 3, axis=1)
    np.testing.assert_array_equal(heard, total.astype(PRECISION))


@both_spaces
def test_likelihoods_compare_predicted_postures_in_either_space(models: str) -> None:
    agent = mosaic(models=models, sigma=0.1)
    trace = dance(agent, 3)
    modules = trace.modules
    assert np.ptp(modules.responsibility / modules.prior) > 0.1
    for t in range(1, 20):
        errors = prediction_errors(modules.predictions[t - 1], trace.posture[t])
        expected = responsibilities(modules.prior[t], likelihood(errors, 0.1))
        np.testing.assert_allclose(modules.responsibility[t], expected, atol=1e-12)


def test_the_inverse_models_rate_depends_on_the_models_if_not_given() -> None:
    rates = {"joint": 0.02, "posture": 0.2}
    for models, rate in rates.items():
        assert vars(mosaic(models=models)._rule)["inverse_rate"] == rate
        assert vars(mosaic(models=models, inverse_rate=0.1)._rule)["inverse_rate"] == 0.1


@both_spaces
def test_responsibilities_sum_to_one_and_mix_the_command(models: str) -> None:
    agent = mosaic(models=models)
    dance(agent, 3)
    inverse = agent.gains.inverse
    trace = dance(agent, 1)
    np.testing.assert_allclose(trace.modules.responsibility.sum(axis=1), 1.0)
    mixed = np.einsum("tm,tmj->tj", trace.modules.responsibility, trace.modules.module_actions)
    total = np.clip(inverse * mixed + trace.feedback, -1, 1)
    np.testing.assert_allclose(trace.action, total, atol=1e-14)


def test_one_module_is_always_responsible() -> None:
    np.testing.assert_array_equal(dance(mosaic(1), 2).modules.responsibility, 1.0)


def test_without_observing_nothing_is_learned() -> None:
    agent, env = mosaic(), load("ymca")
    before = agent.state_dict()
    agent.act(env.reset().observation)
    for name, value in before.items():
        np.testing.assert_array_equal(agent.state_dict()[name], value)


@both_spaces
def test_a_copy_of_the_state_continues_alike(models: str) -> None:
    trained, copy = mosaic(models=models), mosaic(models=models)
    dance(trained, 3)
    copy.load_state_dict(trained.state_dict())
    np.testing.assert_array_equal(dance(trained, 1).action, dance(copy, 1).action)
    for name, value in trained.state_dict().items():
        np.testing.assert_array_equal(value, copy.state_dict()[name])


def test_learning_does_not_change_a_state_that_was_returned() -> None:
    agent = mosaic()
    dance(agent, 1)
    state = agent.state_dict()
    kept = {name: value.copy() for name, value in state.items()}
    dance(agent, 1)
    for name, value in kept.items():
        np.testing.assert_array_equal(state[name], value)
    assert not np.array_equal(agent.state_dict()["forward.weights"], kept["forward.weights"])


@both_spaces
def test_with_control_it_tracks_better_than_feedback(models: Any) -> None:
    env = load("ymca", arms="kinematic")
    agent = make_agent(env, MOSAICConfig(modules=2, models=models), kind="mosaic")
    for epoch in range(30):
        trace = record_epoch(env, agent, epoch)
        logged = agent.learn()
    alone = record_epoch(env, make_agent(env, kind="feedback_only"), 29)
    assert logged["gain_inverse"] == 1.0
    error, usual = (np.abs(t.posture - t.reference).mean() for t in (trace, alone))
    assert error < usual


def test_nothing_is_learned_from_the_first_observation() -> None:
    agent = mosaic()
    before = agent.state_dict()
    agent.observe(load("ymca", arms="kinematic").reset())
    for name, value in agent.state_dict().items():
        np.testing.assert_array_equal(value, before[name])
