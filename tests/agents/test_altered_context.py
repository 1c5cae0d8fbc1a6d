"""Agents that hear something else than which part of the dance is on."""

import dataclasses
import itertools
from typing import Any

import dm_env
import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mpma_mj.agents import Agent, AgentConfig, AgentSpec
from mpma_mj.agents.wrappers import AlteredContext, altered_context, altered_context_size
from mpma_mj.context import active_label, one_hot
from mpma_mj.envs.load import load
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca
from mpma_mj.options import ContextSignal
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of

LABELS = 3
LONG = 1000  # more than an episode: no seam
CONTEXT = one_hot(np.repeat([0, 1, 2, 0, 2], [4, 5, 3, 6, 2]), LABELS)


class Listener(Agent):
    """Remembers which contexts it receives, and how many of its like there are."""

    def __init__(self) -> None:
        super().__init__(AgentConfig(), AgentSpec(LABELS, np.ones(8), 0.05))
        self.heard: list[np.ndarray] = []
        self.best: list[int] = []

    def reset(self, episode: int) -> None:
        self.heard = []

    def select_runs(self, runs: np.ndarray) -> None:
        self.best = runs.tolist()

    def act(self, observation: Any) -> np.ndarray:
        self.heard.append(observation["context"])
        return np.zeros((*observation["context"].shape[:-1], 8))


def heard(hearing: AlteredContext, episode: int) -> np.ndarray:
    """Return what is heard in an episode, (T, ..., C)."""
    hearing.reset(episode)
    for moment in CONTEXT:
        hearing.act({"context": moment})
        hearing.observe(dm_env.transition(0.0, {"context": moment}))
    assert isinstance(hearing.agent, Listener)
    return np.stack(hearing.agent.heard)


def test_labels_are_heard_as_they_are_by_who_hears_them() -> None:
    np.testing.assert_array_equal(
        altered_context(CONTEXT, "labels", LONG, np.random.default_rng(0)), CONTEXT
    )


@pytest.mark.parametrize(("context_signal", "sound"), [("nothing", 0.0), ("constant", 1.0)])
def test_nothing_and_a_constant_sound_tell_nothing(
    context_signal: ContextSignal, sound: float
) -> None:
    found = heard(AlteredContext(Listener(), context_signal, CONTEXT, LONG, 0), 0)
    assert found.shape == CONTEXT.shape
    assert (found == sound).all()


def test_shuffled_is_the_same_moments_in_another_order_each_episode() -> None:
    hearing = AlteredContext(Listener(), "shuffled", CONTEXT, LONG, 0)
    first, second, again = (heard(hearing, episode) for episode in (0, 1, 0))
    for found in (first, second):
        np.testing.assert_array_equal(found.sum(axis=0), CONTEXT.sum(axis=0))
        np.testing.assert_array_equal(found.sum(axis=1), 1.0)
        assert not np.array_equal(found, CONTEXT)
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(first, again)
    other = heard(AlteredContext(Listener(), "shuffled", CONTEXT, LONG, 1), 0)
    assert not np.array_equal(first, other)


@hypothesis.given(
    stretches=st.lists(st.tuples(st.integers(-1, 2), st.integers(1, 9)), min_size=1, max_size=8)
)
def test_halves_cut_every_stretch_in_two_and_leave_silence(
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
def test_each_repetition_is_heard_in_halves_as_the_first(label: list[int], repeats: int) -> None:
    once = np.where(np.array(label)[:, None] >= 0, one_hot(np.array(label), LABELS), 0.0)
    rng = np.random.default_rng(0)
    alone = altered_context(once, "halves", len(label), rng)
    again = altered_context(np.tile(once, (repeats, 1)), "halves", len(label), rng)
    np.testing.assert_array_equal(again, np.tile(alone, (repeats, 1)))


def test_one_label_is_cut_at_the_seam_too() -> None:
    fine = altered_context(np.ones((8, 1)), "halves", 4, np.random.default_rng(0))
    np.testing.assert_array_equal(active_label(fine), [0, 0, 1, 1, 0, 0, 1, 1])


def test_an_agent_hears_each_repetition_of_its_environment_alike() -> None:
    dance = ymca()  # so heard that the label of its end is the label of its start
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


def test_what_cannot_be_heard_is_refused_with_the_list() -> None:
    with pytest.raises(BadOptionError) as error:
        AlteredContext(Listener(), "noise", CONTEXT, LONG, 0)  # type: ignore[arg-type]
    assert str(error.value) == (
        "context_signal is 'noise'; expected one of labels, nothing, constant, shuffled, halves"
    )


@pytest.mark.parametrize("context_signal", ["nothing", "constant", "shuffled", "halves"])
def test_side_by_side_each_hears_what_it_hears_alone(context_signal: ContextSignal) -> None:
    together = AlteredContext(Listener(), context_signal, CONTEXT, LONG, [5, 0, 7])
    for episode in range(2):
        found = heard(together, episode)
        assert found.shape == (len(CONTEXT), 3, altered_context_size(context_signal, LABELS))
        for member, seed in enumerate((5, 0, 7)):
            own = heard(AlteredContext(Listener(), context_signal, CONTEXT, LONG, seed), episode)
            np.testing.assert_array_equal(found[:, member], own)


def test_those_who_stay_go_on_hearing_what_they_would_have_contexts() -> None:
    together = AlteredContext(Listener(), "shuffled", CONTEXT, LONG, [5, 0, 7])
    before = heard(together, 1)
    together.select_runs(np.array([0, 2]))
    np.testing.assert_array_equal(heard(together, 1), before[:, [0, 2]])
    assert isinstance(together.agent, Listener)
    assert together.agent.best == [0, 2]
