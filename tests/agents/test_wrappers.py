"""Wrappers of agents: an altered context, and learning switched off."""

import dataclasses
import itertools
from typing import Any

import dm_env
import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mpma_mj import MPMAConfig, make_agent
from mpma_mj.agents import Agent, AgentConfig, AgentSpec
from mpma_mj.agents.wrappers import (
    AgentWrapper,
    AlteredContext,
    Frozen,
    altered_context,
    altered_context_size,
)
from mpma_mj.context import active_label, one_hot
from mpma_mj.envs.load import load
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca
from mpma_mj.options import ContextSignal
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of
from mpma_mj.training.rollout import record_epoch

LABELS = 3
LONG = 1000  # more than an episode: no seam
CONTEXT = one_hot(np.repeat([0, 1, 2, 0, 2], [4, 5, 3, 6, 2]), LABELS)


class Recorder(Agent):
    """Records the contexts that it receives, and the selected runs."""

    def __init__(self) -> None:
        super().__init__(AgentConfig(), AgentSpec(LABELS, np.ones(8), 0.05))
        self.contexts: list[np.ndarray] = []
        self.best: list[int] = []

    def reset(self, episode: int) -> None:
        self.contexts = []

    def select_runs(self, runs: np.ndarray) -> None:
        self.best = runs.tolist()

    def act(self, observation: Any) -> np.ndarray:
        self.contexts.append(observation["context"])
        return np.zeros((*observation["context"].shape[:-1], 8))


def received(altered: AlteredContext, episode: int) -> np.ndarray:
    """Return the contexts that an agent receives in an episode, (T, ..., C)."""
    altered.reset(episode)
    for moment in CONTEXT:
        altered.act({"context": moment})
        altered.observe(dm_env.transition(0.0, {"context": moment}))
    assert isinstance(altered.agent, Recorder)
    return np.stack(altered.agent.contexts)


def test_the_signal_labels_is_the_context_itself() -> None:
    np.testing.assert_array_equal(
        altered_context(CONTEXT, "labels", LONG, np.random.default_rng(0)), CONTEXT
    )


@pytest.mark.parametrize(("context_signal", "sound"), [("nothing", 0.0), ("constant", 1.0)])
def test_nothing_is_zeros_and_constant_is_ones(context_signal: ContextSignal, sound: float) -> None:
    found = received(AlteredContext(Recorder(), context_signal, CONTEXT, LONG, 0), 0)
    assert found.shape == CONTEXT.shape
    assert (found == sound).all()


def test_shuffled_is_another_order_of_the_same_steps_in_each_episode() -> None:
    altered = AlteredContext(Recorder(), "shuffled", CONTEXT, LONG, 0)
    first, second, again = (received(altered, episode) for episode in (0, 1, 0))
    for found in (first, second):
        np.testing.assert_array_equal(found.sum(axis=0), CONTEXT.sum(axis=0))
        np.testing.assert_array_equal(found.sum(axis=1), 1.0)
        assert not np.array_equal(found, CONTEXT)
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(first, again)
    other = received(AlteredContext(Recorder(), "shuffled", CONTEXT, LONG, 1), 0)
    assert not np.array_equal(first, other)


@hypothesis.given(
    stretches=st.lists(st.tuples(st.integers(-1, 2), st.integers(1, 9)), min_size=1, max_size=8)
)
def test_halves_cut_every_stretch_in_two_and_leave_steps_without_label(
    stretches: list[tuple[int, int]],
) -> None:
    label = np.concatenate([np.full(length, which) for which, length in stretches])
    context = np.where((label >= 0)[:, None], one_hot(label, LABELS), 0.0)
    fine = altered_context(context, "halves", LONG, np.random.default_rng(0))
    assert fine.shape == (len(label), altered_context_size("halves", LABELS)) == (len(label), 6)
    np.testing.assert_array_equal(fine.reshape(-1, LABELS, 2).sum(axis=2), context)
    half = active_label(fine)
    ends = [0, *np.flatnonzero(np.diff(label)) + 1, len(label)]
    for start, end in itertools.pairwise(ends):
        if label[start] < 0:
            assert (fine[start:end] == 0).all()
            continue
        later = half[start:end] - 2 * label[start]
        assert (np.diff(later) >= 0).all()
        assert later.sum() == (end - start) // 2


@hypothesis.given(
    label=st.lists(st.integers(-1, 2), min_size=1, max_size=12), repeats=st.integers(1, 4)
)
def test_halves_of_each_repetition_are_those_of_the_first(label: list[int], repeats: int) -> None:
    once = np.where(np.array(label)[:, None] >= 0, one_hot(np.array(label), LABELS), 0.0)
    rng = np.random.default_rng(0)
    alone = altered_context(once, "halves", len(label), rng)
    again = altered_context(np.tile(once, (repeats, 1)), "halves", len(label), rng)
    np.testing.assert_array_equal(again, np.tile(alone, (repeats, 1)))


def test_one_label_is_cut_at_the_seam_too() -> None:
    fine = altered_context(np.ones((8, 1)), "halves", 4, np.random.default_rng(0))
    np.testing.assert_array_equal(active_label(fine), [0, 0, 1, 1, 0, 0, 1, 1])


def test_each_repetition_of_the_environment_has_the_same_halves() -> None:
    dance = ymca()  # with the same label at its end and its start
    motion = dataclasses.replace(dance, context=np.roll(dance.context, 9, axis=0))
    env = load(motion, arms="kinematic", repeats=2)
    assert (motion.context[0] == motion.context[-1]).all()
    config = RunConfig.of(context_signal="halves", nodes=2, modules=1, repeats=2, arms="kinematic")
    agent = agent_of(config, env, 0)
    assert isinstance(agent, AlteredContext)
    envs = VectorImitationEnv(2, motion=motion, arms="kinematic", repeats=2)
    together = agent_of(config, envs, 0)
    assert isinstance(together, AlteredContext)
    period = env.task.period
    moments = agent._contexts
    np.testing.assert_array_equal(moments[:period][: len(moments) - period], moments[period:])
    for member in range(2):
        np.testing.assert_array_equal(together._contexts[:, member], moments)


def test_unknown_context_signals_are_refused_with_the_list() -> None:
    with pytest.raises(BadOptionError) as error:
        AlteredContext(Recorder(), "noise", CONTEXT, LONG, 0)  # type: ignore[arg-type]
    assert str(error.value) == (
        "context_signal is 'noise'; expected one of labels, nothing, constant, shuffled, halves"
    )


@pytest.mark.parametrize("context_signal", ["nothing", "constant", "shuffled", "halves"])
def test_each_run_of_a_batch_has_the_context_that_it_has_alone(
    context_signal: ContextSignal,
) -> None:
    together = AlteredContext(Recorder(), context_signal, CONTEXT, LONG, [5, 0, 7])
    for episode in range(2):
        found = received(together, episode)
        assert found.shape == (len(CONTEXT), 3, altered_context_size(context_signal, LABELS))
        for member, seed in enumerate((5, 0, 7)):
            own = received(AlteredContext(Recorder(), context_signal, CONTEXT, LONG, seed), episode)
            np.testing.assert_array_equal(found[:, member], own)


def test_selected_runs_keep_their_contexts() -> None:
    together = AlteredContext(Recorder(), "shuffled", CONTEXT, LONG, [5, 0, 7])
    before = received(together, 1)
    together.select_runs(np.array([0, 2]))
    np.testing.assert_array_equal(received(together, 1), before[:, [0, 2]])
    assert isinstance(together.agent, Recorder)
    assert together.agent.best == [0, 2]


@pytest.mark.parametrize("kind", ["mosaic", "adaptive"])
def test_a_frozen_agent_learns_nothing_not_even_at_every_step(kind: str) -> None:
    env = load("ymca", arms="kinematic", repeats=1)
    agent = make_agent(env, MPMAConfig(nodes=10, modules=2), kind=kind)
    record_epoch(env, agent, 0)
    agent.learn()
    before = agent.state_dict()
    frozen = Frozen(agent)
    record_epoch(env, frozen, 1)
    assert frozen.learn() == {}
    for name, value in agent.state_dict().items():
        np.testing.assert_array_equal(value, before[name], err_msg=name)


def test_a_wrapper_is_trainable_as_the_agent_inside_and_a_frozen_one_is_not() -> None:
    agent = make_agent(load("ymca"), MPMAConfig(nodes=5))
    wrapped, frozen = AgentWrapper(agent), Frozen(agent)
    flags = [(own.trainable, own.fine_tunable, own.has_modules) for own in (wrapped, frozen)]
    assert flags == [(True, True, True), (False, False, True)]
    assert not AgentWrapper(Recorder()).trainable
