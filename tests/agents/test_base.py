"""What all agents have in common, alone and in batches."""

from typing import Any

import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent, make_vec
from mpma_mj.agents import AGENTS, Agent, AgentConfig, DMPConfig, ProMPConfig
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError, StateError
from mpma_mj.training.rollout import record_epoch

SMALL = MPMAConfig(nodes=10, modules=2)
OWN: dict[str, AgentConfig] = {
    "promp": ProMPConfig(demonstrations=2),
    "dmp": DMPConfig(demonstrations=2),
}
LEARNING = [kind for kind in AGENTS if AGENTS[kind].trainable]


@pytest.fixture(scope="module")
def envs() -> VectorImitationEnv:
    return make_vec(3, "ymca", arms="kinematic", repeats=1)


def many(envs: VectorImitationEnv, kind: str, seed: Any = 0) -> Agent:
    return make_agent(envs, OWN.get(kind, SMALL), kind=kind, seed=seed)


def actions(envs: VectorImitationEnv, agent: Agent, epoch: int) -> np.ndarray:
    """Act and learn; return the actions, shape (R, T, 8)."""
    trace = record_epoch(envs, agent, epoch)
    agent.learn()
    return np.moveaxis(trace.action, 0, 1)


@pytest.mark.parametrize("seeds", [[4, 5, 6], (4, 5, 6), np.array([4, 5, 6]), range(4, 7)])
def test_an_integer_seed_stands_for_itself_and_those_that_follow(
    envs: VectorImitationEnv, seeds: object
) -> None:
    listed, numbered = many(envs, "mpma", seeds), many(envs, "mpma", 4)
    for epoch in range(2):
        danced = actions(envs, listed, epoch)
        np.testing.assert_array_equal(danced, actions(envs, numbered, epoch))
    assert not np.array_equal(danced, actions(envs, many(envs, "mpma", [6, 5, 4]), 0))


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        ([1, 2], "seed has 2 entries; expected 3"),
        ([], "seed has 0 entries; expected 3"),
        ("123", "seed is '123'; expected a whole number from 0 up"),
        ([1, 2, -3], "seed is -3"),
        ([1, None, 3], "seed is None"),
        (np.array([0.5, 1.0, 2.0]), "seed is 0.5"),
        (None, "seed is None"),
        (True, "seed is True"),
    ],
)
def test_invalid_seeds_are_refused(envs: VectorImitationEnv, seed: object, message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        many(envs, "mpma", seed)


def test_flat_environments_are_refused() -> None:
    with pytest.raises(BadOptionError, match=r"env is flat, .* by name; leave flat out"):
        make_agent(make_vec(2, "ymca", flat=True), SMALL)


@pytest.mark.parametrize("kind", LEARNING)
def test_a_copy_of_a_batchs_state_continues_alike(envs: VectorImitationEnv, kind: str) -> None:
    trained, copy = many(envs, kind), many(envs, kind)
    for epoch in range(2):
        actions(envs, trained, epoch)
    copy.load_state_dict(trained.state_dict())
    for epoch in (2, 3):
        danced = actions(envs, trained, epoch)
        np.testing.assert_array_equal(danced, actions(envs, copy, epoch))
    fresh = actions(envs, many(envs, kind), 3)
    assert not np.array_equal(danced, fresh)
    for name, value in trained.state_dict().items():
        np.testing.assert_array_equal(value, copy.state_dict()[name])


@pytest.mark.parametrize("kind", LEARNING)
def test_logged_values_have_the_shape_of_the_batch(envs: VectorImitationEnv, kind: str) -> None:
    agent = many(envs, kind)
    record_epoch(envs, agent, 0)
    logged = agent.learn()
    assert {"gain_feedback", "gain_inverse"} <= logged.keys() or "learner_acts" in logged
    assert {values.shape for values in logged.values()} == {(3,)}
    env = load("ymca", arms="kinematic", repeats=1)
    alone = make_agent(env, SMALL, kind=kind)
    record_epoch(env, alone, 0)
    assert {name: np.shape(value) for name, value in alone.learn().items()} == dict.fromkeys(
        logged, ()
    )


@pytest.mark.parametrize("kind", LEARNING)
def test_before_a_step_there_are_no_signals_and_learn_is_refused(kind: str) -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make_agent(env, SMALL, kind=kind)
    before = agent.state_dict()

    def refused() -> None:
        with pytest.raises(StateError, match=r"before an episode; call act\(\) and observe"):
            agent.learn()

    assert agent.signals().modules is agent.signals().feedback is None
    refused()
    agent.act(env.reset().observation)
    refused()
    for name, value in agent.state_dict().items():
        np.testing.assert_array_equal(value, before[name])
    record_epoch(env, agent, 0)
    agent.learn()
    agent.reset(1)
    assert agent.signals().modules is agent.signals().feedback is None
    refused()


def test_mosaic_has_no_gram_matrices_as_it_is_never_fitted(envs: VectorImitationEnv) -> None:
    agent = many(envs, "mosaic")
    actions(envs, agent, 0)
    assert not [name for name in agent.state_dict() if name.endswith((".gram", ".moment"))]
    fitted = many(envs, "mpma")
    actions(envs, fitted, 0)
    assert "forward.gram" in fitted.state_dict()
