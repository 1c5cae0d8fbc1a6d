"""MPMA that is told which plant is on."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import load, make_agent, make_vec
from mpma_mj.agents import Oracle, OracleConfig
from mpma_mj.errors import BadOptionError
from mpma_mj.metrics import posture_error_percent
from mpma_mj.training.rollout import record_epoch

SMALL = OracleConfig(nodes=10, modules=2, max_plants=2)
PLANTS: list[dict[str, float]] = [{}, {"actuator_gain": 0.5}]
IDEAL: dict[str, Any] = {"arms": "kinematic", "repeats": 1}


def oracle(env: Any, config: OracleConfig = SMALL, seed: Any = 0) -> Any:
    agent = make_agent(env, config, kind="oracle", seed=seed)
    assert isinstance(agent, Oracle)
    return agent


def plant_shares(trace: Any) -> np.ndarray:
    """Return the responsibility of all modules of each plant, shape (T, 2)."""
    return trace.modules.responsibility.reshape(len(trace), 2, 2).sum(axis=2)


@pytest.mark.parametrize("switching", [{"epochs_per_plant": 1}, {"switch_every": (0.3, 0.6)}])
def test_the_modules_of_the_plant_that_is_told_have_all_responsibility(
    switching: dict[str, Any],
) -> None:
    env = load("ymca", plants=PLANTS, **switching, **IDEAL)
    agent = oracle(env)
    met = set()
    for epoch in range(3):
        trace = record_epoch(env, agent, epoch)
        np.testing.assert_allclose(plant_shares(trace), np.eye(2)[trace.plant], atol=1e-12)
        agent.learn()
        met |= set(trace.plant.tolist())
    assert met == {0, 1}


def test_only_the_plant_that_is_told_learns() -> None:
    env = load("ymca", plants=PLANTS, epochs_per_plant=1, **IDEAL)
    agent = oracle(env)
    for epoch in range(4):
        before = agent.state_dict()
        record_epoch(env, agent, epoch)
        agent.learn()
        after = agent.state_dict()
        for name in ("inverse.weights", "forward.weights"):
            change = np.abs(after[name] - before[name]).reshape(2, -1).max(axis=1)
            assert change[epoch % 2] > 0.0
            assert change[1 - epoch % 2] == 0.0


def test_with_plants_told_it_dances_in_each() -> None:
    env = load("ymca", plants=PLANTS, epochs_per_plant=1, **IDEAL)
    agent = oracle(env)
    for epoch in range(6):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
        error = posture_error_percent(trace.posture, trace.reference)
        # The gains follow after the first epoch, in which the first plant was on.
        assert epoch < 2 or error < 0.3


def test_plants_prefer_the_same_modules_for_a_label_from_the_start() -> None:
    preferences = oracle(load("ymca", **IDEAL)).state_dict()["preferences"]
    np.testing.assert_array_equal(preferences[1], preferences[0])
    assert preferences[0].any()


def test_more_plants_than_it_may_have_are_refused_by_the_options_name() -> None:
    env = load("ymca", plants=[*PLANTS, {"actuator_gain": 2.0}], epochs_per_plant=1, **IDEAL)
    agent = oracle(env)
    record_epoch(env, agent, 1)
    message = "max_plants is 2; expected at least 3, one for each plant of the environment"
    with pytest.raises(BadOptionError, match=message) as error:
        record_epoch(env, agent, 2)
    assert error.value.option == "max_plants"


def test_without_plants_it_takes_the_first() -> None:
    env = load("ymca", **IDEAL)
    agent = oracle(env)
    trace = record_epoch(env, agent, 0)
    np.testing.assert_allclose(plant_shares(trace), [[1.0, 0.0]] * len(trace))
    untold = oracle(env)
    untold.reset(0)
    env.task.episode = 0
    np.testing.assert_array_equal(untold.act(env.reset().observation), trace.action[0])


def test_each_run_of_a_batch_is_told_its_own_plant() -> None:
    env, envs = load("ymca", **IDEAL), make_vec(3, "ymca", **IDEAL)
    batch, alone = oracle(envs, seed=[4, 5, 6]), oracle(env, seed=5)
    told = np.array([0, 1, 0])
    batch.observe_plant(told)
    alone.observe_plant(np.array(1))
    observation, _ = envs.reset()
    action = batch.act(observation)
    own = {name: value[1] for name, value in observation.items()}
    np.testing.assert_array_equal(alone.act(own), action[1])
    shares = batch.signals().modules.responsibility.reshape(3, 2, 2).sum(axis=2)
    np.testing.assert_allclose(shares, np.eye(2)[told])


def test_a_copy_of_the_state_continues_to_the_bit() -> None:
    env = load("ymca", plants=PLANTS, switch_every=(0.3, 0.6), **IDEAL)
    agent, copy = oracle(env), oracle(env)
    for epoch in range(3):
        record_epoch(env, agent, epoch)
        agent.learn()
    copy.load_state_dict(agent.state_dict())
    for epoch in (3, 4):
        expected = record_epoch(env, agent, epoch).to_arrays()
        found = record_epoch(env, copy, epoch).to_arrays()
        for name, signal in expected.items():
            np.testing.assert_array_equal(found[name], signal, err_msg=name)
        agent.learn()
        copy.learn()
