"""Agents that hear something else than which part of the dance is on."""

import itertools
from typing import Any

import dm_env
import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from mpma_mj.agents import FixedAgent
from mpma_mj.agents.hearing import Hearing, heard_size, what_is_heard
from mpma_mj.motions.context import danced_label, one_hot
from mpma_mj.options import HearsName

LABELS = 3
CONTEXT = one_hot(np.repeat([0, 1, 2, 0, 2], [4, 5, 3, 6, 2]), LABELS)


class Listener(FixedAgent):
    """Remembers what it hears, and how many of its like there are."""

    def __init__(self) -> None:
        self.heard: list[np.ndarray] = []
        self.kept: list[int] = []

    def reset(self, episode: int) -> None:
        self.heard = []

    def keep(self, members: np.ndarray) -> None:
        self.kept = members.tolist()

    def act(self, observation: Any) -> np.ndarray:
        self.heard.append(observation["context"])
        return np.zeros((*observation["context"].shape[:-1], 8))


def heard(hearing: Hearing, episode: int) -> np.ndarray:
    """Return what is heard in an episode, (T, ..., C)."""
    hearing.reset(episode)
    for moment in CONTEXT:
        hearing.act({"context": moment})
        hearing.observe(dm_env.transition(0.0, {"context": moment}))
    assert isinstance(hearing.agent, Listener)
    return np.stack(hearing.agent.heard)


def test_labels_are_heard_as_they_are_by_who_hears_them() -> None:
    np.testing.assert_array_equal(
        what_is_heard(CONTEXT, "labels", np.random.default_rng(0)), CONTEXT
    )


@pytest.mark.parametrize(("hears", "sound"), [("nothing", 0.0), ("constant", 1.0)])
def test_nothing_and_a_constant_sound_tell_nothing(hears: HearsName, sound: float) -> None:
    found = heard(Hearing(Listener(), hears, CONTEXT, 0), 0)
    assert found.shape == CONTEXT.shape
    assert (found == sound).all()


def test_shuffled_is_the_same_moments_in_another_order_each_episode() -> None:
    hearing = Hearing(Listener(), "shuffled", CONTEXT, 0)
    first, second, again = (heard(hearing, episode) for episode in (0, 1, 0))
    for found in (first, second):
        np.testing.assert_array_equal(found.sum(axis=0), CONTEXT.sum(axis=0))
        np.testing.assert_array_equal(found.sum(axis=1), 1.0)
        assert not np.array_equal(found, CONTEXT)
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(first, again)
    other = heard(Hearing(Listener(), "shuffled", CONTEXT, 1), 0)
    assert not np.array_equal(first, other)


@hypothesis.given(
    stretches=st.lists(st.tuples(st.integers(-1, 2), st.integers(1, 9)), min_size=1, max_size=8)
)
def test_halves_cut_every_stretch_in_two_and_leave_silence(
    stretches: list[tuple[int, int]],
) -> None:
    label = np.concatenate([np.full(length, which) for which, length in stretches])
    context = np.where((label >= 0)[:, None], one_hot(label, LABELS), 0.0)
    fine = what_is_heard(context, "halves", np.random.default_rng(0))
    assert fine.shape == (len(label), heard_size("halves", LABELS)) == (len(label), 6)
    np.testing.assert_array_equal(fine.reshape(-1, LABELS, 2).sum(axis=2), context)
    half = danced_label(fine)
    ends = [0, *np.flatnonzero(np.diff(label)) + 1, len(label)]
    for start, end in itertools.pairwise(ends):
        if label[start] < 0:
            assert (fine[start:end] == 0).all()
            continue
        later = half[start:end] - 2 * label[start]
        assert (np.diff(later) >= 0).all()
        assert later.sum() == (end - start) // 2


@pytest.mark.parametrize("hears", ["nothing", "constant", "shuffled", "halves"])
def test_side_by_side_each_hears_what_it_hears_alone(hears: HearsName) -> None:
    together = Hearing(Listener(), hears, CONTEXT, [5, 0, 7])
    for episode in range(2):
        found = heard(together, episode)
        assert found.shape == (len(CONTEXT), 3, heard_size(hears, LABELS))
        for member, seed in enumerate((5, 0, 7)):
            own = heard(Hearing(Listener(), hears, CONTEXT, seed), episode)
            np.testing.assert_array_equal(found[:, member], own)


def test_those_who_stay_go_on_hearing_what_they_would_have_heard() -> None:
    together = Hearing(Listener(), "shuffled", CONTEXT, [5, 0, 7])
    before = heard(together, 1)
    together.keep(np.array([0, 2]))
    np.testing.assert_array_equal(heard(together, 1), before[:, [0, 2]])
    assert isinstance(together.agent, Listener)
    assert together.agent.kept == [0, 2]
