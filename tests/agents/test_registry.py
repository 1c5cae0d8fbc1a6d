import numpy as np
import pytest

from mpma_mj import MPMAConfig, load, make_agent
from mpma_mj.agents import AGENTS, MPMA, SingleConfig
from mpma_mj.errors import BadOptionError
from mpma_mj.training.rollout import record_epoch

SMALL = MPMAConfig(nodes=20, modules=2)
LEARNING = (
    "mpma",
    "mosaic",
    "hammer",
    "single",
    "adaptive",
    "oracle",
    "bc",
    "dagger",
    "promp",
    "dmp",
)


def actions(kind: str, seed: int, epochs: int = 2) -> np.ndarray:
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make_agent(env, SMALL, kind=kind, seed=seed)
    for epoch in range(epochs):
        trace = record_epoch(env, agent, epoch)
        agent.learn()
    return trace.action


def test_all_built_in_agents_are_registered() -> None:
    assert list(AGENTS) == [*LEARNING, "resolved_rate", "feedback_only", "open_loop", "random"]


@pytest.mark.parametrize("kind", AGENTS)
def test_every_agent_acts_and_learns(kind: str) -> None:
    action = actions(kind, 0)
    assert action.shape[1] == 8
    assert np.abs(action).max() <= 1.0


# Movement primitives draw nothing.
@pytest.mark.parametrize("kind", [*LEARNING[:-2], "random"])
def test_seed_zero_is_a_seed(kind: str) -> None:
    np.testing.assert_array_equal(actions(kind, 0), actions(kind, 0))
    assert not np.array_equal(actions(kind, 0), actions(kind, 1))


@pytest.mark.parametrize(("kind", "pairs"), [("mpma", 2), ("mosaic", 2), ("hammer", 4)])
def test_hammer_has_a_pair_for_each_label_and_others_as_configured(kind: str, pairs: int) -> None:
    env = load("ymca", repeats=1)
    agent = make_agent(env, SMALL, kind=kind)
    assert record_epoch(env, agent, 0).modules.responsibility.shape[1] == pairs


def test_single_is_mpma_of_one_module() -> None:
    env = load("ymca")
    agent = make_agent(env, SMALL, kind="single")
    assert isinstance(agent, MPMA)
    assert agent.config == SingleConfig(nodes=20)
    one = make_agent(env, MPMAConfig(nodes=20, modules=1))
    observation = env.reset().observation
    np.testing.assert_array_equal(agent.act(observation), one.act(observation))


def test_unknown_agents_are_refused_in_one_line_with_the_list() -> None:
    with pytest.raises(BadOptionError) as error:
        make_agent(load("ymca"), kind="mosiac")
    assert str(error.value) == (
        "agent is 'mosiac'; expected one of mpma, mosaic, hammer, single, adaptive,"
        " oracle, bc, dagger, promp, dmp, resolved_rate, feedback_only, open_loop, random, or the"
        " path of a class, such as my_agents.py:MyAgent; did you mean mosaic?"
    )
