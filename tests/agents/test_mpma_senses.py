"""MPMA, single pair and oracle whose observations are late or noisy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents import MPMA, Agent, HAMMERConfig, MOSAICConfig, OracleConfig, SingleConfig
from mpma_mj.agents.late_senses import LateSenses
from mpma_mj.errors import BadOptionError
from mpma_mj.metrics import posture_error_percent
from mpma_mj.trace import Trace
from mpma_mj.training.factory import Environments
from mpma_mj.training.rollout import record_epoch

SMALL: dict[str, Any] = {"nodes": 10, "modules": 2}
ONCE: dict[str, Any] = {"repeats": 1}
LATE: dict[str, Any] = {"latency": (0, 3), "latency_every": (0.5, 1.5), "lookahead": 6}


def trained(env: Environments, epochs: int, config: Any, seed: Any = 0) -> tuple[Agent, Trace]:
    """Return an agent, and the trace of its last epoch, before it learned from it."""
    agent = make_agent(env, config, seed=seed)
    for epoch in range(epochs):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
    return agent, trace


def p_e(trace: Trace) -> float:
    return posture_error_percent(trace.posture[1:], trace.reference[1:])


@pytest.mark.parametrize("kind", [MPMAConfig, SingleConfig, OracleConfig])
def test_a_latency_beyond_the_largest_that_is_made_up_for_is_refused(kind: Any) -> None:
    env = load("ymca", latency=4)
    with pytest.raises(BadOptionError, match=r"max_latency is 3; expected at least 4, .* or 0"):
        make_agent(env, kind(max_latency=3))
    for most in (0, 4):
        make_agent(env, kind(max_latency=most, nodes=5))


def test_the_history_of_moves_is_refused_where_it_would_be_late() -> None:
    message = r"history is True; its moves are late: leave it out, or choose max_latency=0 without"
    for options in ({"latency": 2}, {"latency": (0, 2)}):
        with pytest.raises(BadOptionError, match=message):
            make_agent(load("ymca", **options), MPMAConfig(history=True))
        make_agent(load("ymca", **options), MPMAConfig(history=True, max_latency=0))
    with pytest.raises(BadOptionError, match=message):
        make_agent(load("ymca"), MPMAConfig(history=True, state_estimate=True))
    make_agent(load("ymca"), MPMAConfig(history=True))


@pytest.mark.parametrize("options", [{"max_latency": 3}, {"state_estimate": True}])
@pytest.mark.parametrize("kind", [MPMAConfig, SingleConfig])
def test_posture_models_have_neither(kind: Any, options: dict[str, Any]) -> None:
    (name,) = options
    with pytest.raises(BadOptionError, match=f"{name} is .*posture models do not use it"):
        kind(models="posture", rule="gated", **options)
    kind(models="posture", rule="gated")


@pytest.mark.parametrize("most", [-1, 101, 1.5, True])
def test_the_largest_latency_is_a_whole_number_of_steps(most: Any) -> None:
    with pytest.raises(BadOptionError, match="max_latency is"):
        MPMAConfig(max_latency=most)


@pytest.mark.parametrize(
    ("config", "latency"), [(MOSAICConfig(**SMALL), 2), (HAMMERConfig(nodes=10), (0, 2))], ids=str
)
def test_other_agents_learn_with_a_latency_as_before(config: Any, latency: Any) -> None:
    _, trace = trained(load("ymca", latency=latency, **ONCE), 2, config)
    assert np.isfinite(trace.action).all()
    _, same = trained(load("ymca", latency=latency, lookahead=5, **ONCE), 2, config)
    np.testing.assert_array_equal(trace.action, same.action)


def test_posture_models_learn_with_a_latency_as_before() -> None:
    posture = MPMAConfig(models="posture", rule="gated", **SMALL)
    _, trace = trained(load("ymca", latency=1, **ONCE), 2, posture)
    _, same = trained(load("ymca", latency=(1, 1), **ONCE), 2, posture)
    np.testing.assert_array_equal(trace.action, same.action)


@pytest.mark.parametrize("options", [{}, {"observation_noise": 0.02}, {"latency": (0, 0)}], ids=str)
def test_without_latency_nothing_is_made_up_for(options: dict[str, Any]) -> None:
    env = load("ymca", latency=0, lookahead=6, **ONCE)
    agents, traces = zip(
        *(trained(env, 3, MPMAConfig(max_latency=most, **SMALL)) for most in (5, 0)), strict=True
    )
    np.testing.assert_array_equal(traces[0].action, traces[1].action)
    states = [agent.state_dict() for agent in agents]
    for name, array in states[1].items():
        np.testing.assert_array_equal(states[0][name], array)


@pytest.mark.parametrize(
    ("options", "config"),
    [
        (LATE, {}),
        ({"latency": (0, 3)}, {}),
        ({"latency": 2, "lookahead": 3, "observation_noise": 0.02}, {"state_estimate": True}),
        (LATE | {"plants": [{}, {"actuator_gain": 0.5}], "epochs_per_plant": 2}, {}),
    ],
    ids=["jumping", "not shown", "noisy", "plants"],
)
def test_runs_of_a_batch_are_to_the_bit_what_they_are_alone(
    options: dict[str, Any], config: dict[str, Any]
) -> None:
    own, seeds = MPMAConfig(**SMALL, **config), [4, 5]
    envs = make_vec(2, "ymca", seed=4, **ONCE, **options)
    agent, together = trained(envs, 3, own, seed=4)
    assert isinstance(agent, MPMA)
    assert isinstance(agent.senses, LateSenses)
    delays = np.stack(agent.senses.delays)
    for run, seed in enumerate(seeds):
        single, trace = trained(load("ymca", seed=seed, **ONCE, **options), 3, own, seed=seed)
        assert isinstance(single, MPMA)
        assert isinstance(single.senses, LateSenses)
        np.testing.assert_array_equal(together.of_run(run).action, trace.action)
        np.testing.assert_array_equal(delays[:, run], np.stack(single.senses.delays))
        for name, array in single.state_dict().items():
            np.testing.assert_array_equal(agent.state_dict()[name][run], array)
    if isinstance(options["latency"], tuple):
        assert any((row != row[0]).any() for row in delays)
    envs.close()


def test_predictions_of_a_trace_stand_at_the_steps_at_which_their_commands_act() -> None:
    env = load("ymca", latency=3, lookahead=4, **ONCE)
    _, trace = trained(env, 4, MPMAConfig(**SMALL))
    assert trace.modules is not None
    responsibility = trace.modules.responsibility
    predicted = (responsibility[..., None] * trace.modules.predictions).sum(axis=1)
    later = trace.posture[6:-4], trace.posture[3:-7]  # the next, and that of 3 steps before
    at = [posture_error_percent(predicted[5:-4], posture) for posture in later]
    assert at[0] < 0.5 * at[1]


def test_a_known_latency_with_the_future_shown_costs_little() -> None:
    env = load("ymca", latency=2, lookahead=3)
    _, trace = trained(env, 4, MPMAConfig(nodes=20))
    assert p_e(trace) < 0.6
    _, without = trained(env, 4, MPMAConfig(nodes=20, max_latency=0))
    assert p_e(without) > 5.0


def test_a_latency_that_is_not_known_is_found_and_costs_little() -> None:
    env = load("ymca", latency=(0, 4), lookahead=6)
    agent, trace = trained(env, 4, MPMAConfig(nodes=20))
    assert p_e(trace) < 1.0
    assert isinstance(agent, MPMA)
    assert isinstance(agent.senses, LateSenses)
    assert trace.latency is not None
    assert np.mean(np.stack(agent.senses.delays) == trace.latency) > 0.9


def test_a_single_pair_makes_up_for_latency_too() -> None:
    _, trace = trained(load("ymca", latency=2, lookahead=3), 4, SingleConfig(nodes=40))
    assert p_e(trace) < 0.6


def test_a_state_estimate_is_worth_it_under_noise() -> None:
    quiet, noisy = load("ymca"), load("ymca", observation_noise=0.05)
    errors = []
    for estimates in (True, False):
        agent, _ = trained(quiet, 3, MPMAConfig(nodes=20, state_estimate=estimates))
        errors.append(p_e(record_epoch(noisy, agent, 1000)))
    assert errors[0] < 0.6 * errors[1]


@pytest.mark.parametrize("before", [{}, {"latency": (0, 3), "lookahead": 6}, {"latency": 1}])
def test_a_trained_agent_acts_with_another_latency(before: dict[str, Any]) -> None:
    config = MPMAConfig(nodes=20)
    agent, _ = trained(load("ymca", **before), 3, config)

    def at_once(env: Environments, **options: Any) -> float:
        other = make_agent(env, MPMAConfig(nodes=20, **options))
        other.load_state_dict(agent.state_dict())
        return p_e(record_epoch(env, other, 1000))

    known = load("ymca", latency=2)
    assert at_once(known) < at_once(known, max_latency=0) / 3
    jumping = load("ymca", latency=(0, 3), latency_every=(1.0, 3.0), lookahead=6)
    assert at_once(jumping) < at_once(jumping, max_latency=0) / 3
    assert at_once(load("ymca")) < 1.0
