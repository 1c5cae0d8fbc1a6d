"""Paired models from which modules are dropped."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from mpma_mj.agents.growing import Recruitment

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents import HAMMER, GrowingMPMA
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.agents.wrappers import AlteredContext, Frozen, paired_models_of
from mpma_mj.errors import BadOptionError
from mpma_mj.training.rollout import record_epoch

MODULES = 4  # as many as YMCA has labels, the number that HAMMER has
SMALL = MPMAConfig(nodes=10, modules=MODULES)
KINDS = ["mpma", "mosaic", "hammer", "growing"]

State = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def env() -> Any:
    return load("ymca", arms="kinematic", repeats=1)


@pytest.fixture(scope="module")
def learned(env: Any) -> dict[str, State]:
    """Return the states of trained agents of each kind."""
    states = {}
    for kind in KINDS:
        agent = make_agent(env, SMALL, kind=kind)
        for epoch in range(5):
            record_epoch(env, agent, epoch)
            agent.learn()
        states[kind] = agent.state_dict()
    enabled = Recruitment(modules=3, epochs=1, best_error=1.0)
    states["growing"]["growth"] = enabled.as_row()
    return states


def trained(env: Any, learned: dict[str, State], kind: str) -> Any:
    agent = make_agent(env, SMALL, kind=kind)
    assert isinstance(agent, PairedModels)
    agent.load_state_dict(learned[kind])
    return agent


def without(env: Any, learned: dict[str, State], kind: str, *lost: int) -> Any:
    agent = trained(env, learned, kind)
    agent.drop_modules(lost)
    return agent


@pytest.mark.parametrize("kind", KINDS)
def test_dropping_no_module_changes_no_bit(env: Any, learned: dict[str, State], kind: str) -> None:
    one, other = trained(env, learned, kind), without(env, learned, kind)
    for epoch in (5, 6):
        danced, same = record_epoch(env, one, epoch), record_epoch(env, other, epoch)
        for name, signal in danced.to_arrays().items():
            np.testing.assert_array_equal(same.to_arrays()[name], signal, err_msg=name)
        one.learn()
        other.learn()
    state = other.state_dict()
    for name, value in one.state_dict().items():
        np.testing.assert_array_equal(state[name], value, err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
def test_remaining_modules_take_their_first_step_as_before(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    whole, part = trained(env, learned, kind), without(env, learned, kind, 1)
    env.task.episode = 7
    observation = env.reset().observation
    for agent in (whole, part):
        agent.reset(7)
        agent.act(observation)
    intact, after = whole.signals().modules, part.signals().modules
    left = [0, 2, 3]
    actions = intact.module_actions[:, left]
    np.testing.assert_allclose(after.module_actions, actions, atol=1e-12)
    assert np.abs(actions).max() > 0.01
    if kind != "hammer":  # in which one has all
        share = intact.responsibility[:, left]
        expected = share / share.sum()
        np.testing.assert_allclose(after.responsibility, expected, atol=1e-12)


@pytest.mark.parametrize("kind", ["mpma", "mosaic", "growing"])
def test_remaining_modules_learn(env: Any, learned: dict[str, State], kind: str) -> None:
    agent = without(env, learned, kind, 0, 2)
    before = agent.state_dict()
    trace = record_epoch(env, agent, 5)
    np.testing.assert_allclose(trace.modules.responsibility.sum(axis=1), 1.0)
    agent.learn()
    for name, value in agent.state_dict().items():
        assert np.isfinite(value).all() or name == "growth"
        assert value.shape == before[name].shape
    weights = agent.state_dict()["inverse.weights"]
    assert weights.shape[0] == MODULES - 2
    assert not np.array_equal(weights, before["inverse.weights"])


def test_dropping_a_module_without_responsibility_has_no_effect(
    env: Any, learned: dict[str, State]
) -> None:
    whole = trained(env, learned, "growing")
    whole._growth[4] = 1.0  # over, as after dropping a module
    part = without(env, learned, "growing", 3)  # which is not enabled
    for epoch in (5, 6):
        danced, same = record_epoch(env, whole, epoch), record_epoch(env, part, epoch)
        assert not danced.modules.responsibility[:, 3].any()
        np.testing.assert_allclose(same.action, danced.action, atol=1e-9)
        np.testing.assert_allclose(same.posture, danced.posture, atol=1e-9)
        whole.learn()
        part.learn()
    weights = whole.state_dict()["inverse.weights"][:3]
    np.testing.assert_allclose(part.state_dict()["inverse.weights"], weights, atol=1e-6)


def test_dropping_a_module_with_responsibility_changes_the_movement(
    env: Any, learned: dict[str, State]
) -> None:
    whole, part = trained(env, learned, "mpma"), without(env, learned, "mpma", 0)
    danced, other = record_epoch(env, whole, 5), record_epoch(env, part, 5)
    assert np.abs(danced.posture - other.posture).max() > 1e-3


@pytest.mark.parametrize("kind", ["mpma", "hammer", "growing"])
def test_dropping_modules_of_a_batch_equals_dropping_those_of_each_run(kind: str) -> None:
    envs = make_vec(2, "ymca", arms="kinematic", repeats=1)
    together: Any = make_agent(envs, SMALL, kind=kind, seed=[3, 5])
    if kind == "growing":
        together._growth[...] = Recruitment(modules=3).as_row()
    for epoch in range(2):
        record_epoch(envs, together, epoch)
        together.learn()
    alone = make_agent(load("ymca", arms="kinematic", repeats=1), SMALL, kind=kind, seed=5)
    assert isinstance(alone, PairedModels)
    alone.load_state_dict({name: value[1] for name, value in together.state_dict().items()})
    together.drop_modules([1])
    alone.drop_modules([1])
    trace = record_epoch(envs, together, 4).of_run(1)
    env = load("ymca", arms="kinematic", repeats=1, seed=1)
    expected = record_epoch(env, alone, 4)
    np.testing.assert_allclose(trace.action, expected.action, atol=1e-9)
    together.learn()
    alone.learn()
    state = together.state_dict()
    for name, value in alone.state_dict().items():
        np.testing.assert_allclose(state[name][1], value, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_of_the_remaining_state_continues_alike(
    env: Any, learned: dict[str, State], kind: str
) -> None:
    agent, copy = without(env, learned, kind, 1), without(env, learned, kind, 1)
    record_epoch(env, agent, 5)
    agent.learn()
    copy.load_state_dict(agent.state_dict())
    danced = record_epoch(env, agent, 6).action
    np.testing.assert_array_equal(record_epoch(env, copy, 6).action, danced)


@pytest.mark.parametrize("kind", KINDS)
def test_not_all_modules_can_be_dropped(env: Any, learned: dict[str, State], kind: str) -> None:
    agent = trained(env, learned, kind)
    with pytest.raises(BadOptionError, match=r"expected at least one .*module to be left"):
        agent.drop_modules(range(MODULES))
    agent.drop_modules([])  # nor has it lost any
    assert agent.enabled.shape == (MODULES,)


@pytest.mark.parametrize("lost", [(7,), (-1,), (0, 4)])
@pytest.mark.parametrize("kind", ["mpma", "growing"])
def test_modules_that_do_not_exist_cannot_be_dropped(
    env: Any, learned: dict[str, State], kind: str, lost: tuple[int, ...]
) -> None:
    with pytest.raises(BadOptionError, match="expected indices from 0 to 3"):
        without(env, learned, kind, *lost)


def test_after_dropping_a_pair_of_hammer_the_others_keep_their_labels(env: Any) -> None:
    agent = make_agent(env, SMALL, kind="hammer")
    assert isinstance(agent, HAMMER)
    agent.drop_modules([1])
    trace = record_epoch(env, agent, 0)
    label = trace.context[:-1].argmax(axis=1)
    for own, row in {0: [1, 0, 0], 1: [1, 0, 0], 2: [0, 1, 0], 3: [0, 0, 1]}.items():
        assert (trace.modules.responsibility[label == own] == row).all()
        assert (label == own).any()
    agent.learn()
    # No pair learns from the label of the dropped one.
    full = make_agent(env, SMALL, kind="hammer")
    assert isinstance(full, HAMMER)
    episode = agent._epoch(())
    weight = (label[:, None] == [0, 2, 3]).astype(float)
    forward = full._readouts.forward
    forward.drop_modules([1])
    forward.fit(episode.forward_features, episode.next_posture[:, None, :], weight)
    np.testing.assert_array_equal(agent._readouts.forward.weights, forward.weights)


def test_after_dropping_a_pair_hammer_needs_the_whole_context(env: Any) -> None:
    agent = make_agent(env, SMALL, kind="hammer")
    assert isinstance(agent, HAMMER)
    agent.drop_modules([1])
    agent.reset(0)
    observation = dict(env.reset().observation) | {"context": np.zeros(3)}
    with pytest.raises(BadOptionError, match="expected 4 labels, one for each pair"):
        agent.act(observation)


def test_after_dropping_a_module_no_other_is_recruited(env: Any, learned: dict[str, State]) -> None:
    agent = trained(env, learned, "growing")
    assert isinstance(agent, GrowingMPMA)
    np.testing.assert_array_equal(agent.enabled, [True, True, True, False])
    agent.drop_modules([0, 3])
    np.testing.assert_array_equal(agent.enabled, [True, True])
    assert Recruitment.of_row(agent._growth).over
    with pytest.raises(BadOptionError, match="expected at least one enabled module"):
        agent.drop_modules([0, 1])
    intact = trained(env, learned, "growing")
    assert isinstance(intact, GrowingMPMA)
    with pytest.raises(BadOptionError, match="expected at least one enabled module"):
        intact.drop_modules([0, 1, 2])
    intact.drop_modules([])
    assert not Recruitment.of_row(intact._growth).over


def test_inside_all_wrappers_is_the_agent_with_paired_models(env: Any) -> None:
    inner = make_agent(env, dataclasses.replace(SMALL, modules=2))
    heard = AlteredContext(inner, "nothing", env.task.context, env.task.period, 0)
    assert (
        paired_models_of(inner)
        is paired_models_of(heard)
        is paired_models_of(Frozen(heard))
        is inner
    )
    with pytest.raises(
        BadOptionError, match="agent is 'FeedbackOnly'; expected an agent with forward models"
    ):
        paired_models_of(Frozen(make_agent(env, kind="feedback_only")))
