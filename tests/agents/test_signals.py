"""Signals of modules in a batch of runs with different numbers of plants."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents import ModuleSignals
from mpma_mj.training.rollout import record_epoch

IDEAL: dict[str, Any] = {"arms": "kinematic", "repeats": 1}


def signals(prior: np.ndarray) -> ModuleSignals:
    return ModuleSignals(prior, prior, np.zeros((*prior.shape, 8)), np.zeros((*prior.shape, 12)))


def test_modules_of_plants_that_a_run_does_not_have_are_left_out() -> None:
    prior = np.array([[0.5, 0.5, np.nan, np.nan]] * 5)
    present = signals(prior).present()
    np.testing.assert_array_equal(present.prior, [[0.5, 0.5]] * 5)
    assert present.module_actions.shape == (5, 2, 8)
    assert present.predictions.shape == (5, 2, 12)


@pytest.mark.parametrize("prior", [[0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
def test_modules_without_control_stay(prior: list[float]) -> None:
    np.testing.assert_array_equal(signals(np.array([prior] * 5)).present().prior, [prior] * 5)


@pytest.mark.parametrize("kind", ["mpma", "hammer", "mosaic"])
def test_the_last_module_stays_in_the_trace_of_a_run_when_it_is_off(kind: str) -> None:
    envs = make_vec(2, "ymca", **IDEAL)
    agent: Any = make_agent(envs, MPMAConfig(nodes=5, modules=4), kind=kind)
    agent.set_enabled_modules([True, True, True, False])
    modules = record_epoch(envs, agent, 0).of_run(0).modules
    assert modules is not None
    assert modules.prior.shape[1] == 4
    assert not modules.prior[:, 3].any()


def test_each_run_of_a_batch_has_the_modules_of_its_own_plants() -> None:
    config = MPMAConfig(nodes=5, modules=3, max_plants=3)
    envs = make_vec(2, "ymca", **IDEAL)
    agent: Any = make_agent(envs, config)
    record_epoch(envs, agent, 0)
    agent.learn()
    state = agent.state_dict()
    state["plants.recruited"][1] = 2
    agent.load_state_dict(state)
    trace = record_epoch(envs, agent, 1)
    counts = [trace.of_run(run).with_modules().prior.shape[1] for run in range(2)]
    assert counts == [3, 6]
    np.testing.assert_allclose(trace.of_run(1).with_modules().responsibility.sum(axis=1), 1.0)
    env = load("ymca", **IDEAL)
    alone = make_agent(env, config)
    alone.load_state_dict({name: value[0] for name, value in state.items()})
    expected = record_epoch(env, alone, 1).with_modules()
    np.testing.assert_array_equal(trace.of_run(0).with_modules().prior, expected.prior)
