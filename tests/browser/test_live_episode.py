"""Live episodes: of every agent, with moments to which they go back to the bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.agents import AGENTS
from mpma_mj.browser.live_episode import (
    LARGEST_FORCE,
    LiveEpisode,
    Moment,
    error_percent,
    spring_force,
)
from mpma_mj.envs.interventions import Intervention
from mpma_mj.envs.load import make_environment
from mpma_mj.envs.model import geom_colours
from mpma_mj.envs.plants import Plant
from mpma_mj.errors import BadOptionError
from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of
from mpma_mj.training.rollout import record_epoch
from tests.envs.user_models import edited

SIZES = {"modules": 3, "nodes": 10}
PLANTS = (Plant(), Plant(actuator_gain=0.6))
RUNS: dict[str, dict[str, Any]] = {name: {"agent": name} for name in AGENTS} | {
    "gated": {"models": "posture", "rule": "gated"},
    "late": {"latency": 2, "lookahead": 4, "max_latency": 3},
    "jumping": {"latency": (0, 2), "latency_every": (0.5, 1.0), "max_latency": 3},
    "estimating": {"state_estimate": True, "observation_noise": 0.02},
    "altered": {"context_signal": "shuffled"},
    "switching": {"plants": PLANTS, "switch_every": (1.0, 2.0), "max_plants": 2},
}


def made(epochs: int = 3, **options: Any) -> LiveEpisode:
    """Return a live episode of an agent that has learned."""
    sizes = {} if options.get("agent", "mpma") != "mpma" else SIZES
    config = RunConfig().replace(repeats=1, **sizes, **options)
    env = make_environment(ymca(), config.env, 4, adjustable=True)
    agent = agent_of(config, env, 4)
    for epoch in range(epochs if agent.trainable else 0):
        record_epoch(env, agent, epoch)
        agent.learn()
    return LiveEpisode(env, agent, 100)


def advance(episode: LiveEpisode, steps: int, push: Any = None) -> None:
    for _ in range(steps):
        episode.advance(push)


def run(episode: LiveEpisode) -> list[Moment]:
    """Run to the end of the episode, and return all moments."""
    while not episode.is_over:
        episode.advance()
    return list(episode.moments)


def assert_alike(moments: list[Moment], expected: list[Moment]) -> None:
    for one, other in zip(moments, expected, strict=True):
        assert (one.step, one.label, one.plant) == (other.step, other.label, other.plant)
        assert one.summed_error == other.summed_error
        for name in ("posture", "reference", "responsibility", "push"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
        np.testing.assert_array_equal(one.environment.physics, other.environment.physics)


@pytest.mark.parametrize("kind", RUNS)
def test_from_a_moment_every_agent_goes_on_to_the_bit(kind: str) -> None:
    if kind in ("promp", "dmp"):
        pytest.importorskip("movement_primitives")
    episode = made(**RUNS[kind])
    expected = run(episode)
    assert len(expected) == episode.env.task.steps + 1
    for index in (len(expected) - 1, 40, 60, 0):
        episode.go_back(min(index, len(episode.moments) - 1))
        assert_alike(run(episode), expected)
    episode.advance()
    assert episode.number == 101
    assert len(episode.moments) == 1


def test_going_back_repeats_what_was_switched_off_and_done_by_hand() -> None:
    episode = made()
    advance(episode, 10)
    episode.set_enabled_modules([False, True, True])
    episode.intervene(Intervention(payload=2.0))
    advance(episode, 10, np.full((2, 3), 20.0))
    episode.set_enabled_modules([True] * 3)
    advance(episode, 20)
    before = list(episode.moments)
    after = run(episode)[40:]
    episode.go_back(40)
    assert_alike(episode.moments, before)
    assert_alike(run(episode)[40:], after)
    assert episode.enabled_modules is not None
    assert episode.enabled_modules.all()


def test_what_is_set_by_hand_stays_when_it_goes_back() -> None:
    episode = made()
    advance(episode, 20)
    episode.intervene(Intervention(payload=3.0, latency=1))
    episode.set_enabled_modules([True, False, True])
    episode.go_back(10)
    advance(episode, 15)
    assert episode.env.task.latency == 1
    other = made()
    advance(other, 10)
    other.intervene(Intervention(payload=3.0, latency=1))
    other.set_enabled_modules([True, False, True])
    advance(other, 15)
    assert_alike(episode.moments, other.moments)


def test_an_episode_learns_nothing() -> None:
    for kind in ("mpma", "mosaic", "adaptive"):
        episode = made(agent=kind)
        before = episode.agent.state_dict()
        run(episode)
        episode.advance()
        run(episode)
        for name, array in episode.agent.state_dict().items():
            np.testing.assert_array_equal(array, before[name], err_msg=name)


def test_the_error_is_p_e_of_the_steps() -> None:
    moments = run(made())
    postures = np.array([(m.posture, m.reference) for m in moments])
    for first, last in ((0, len(moments) - 1), (10, 50), (30, 31)):
        steps = postures[first + 1 : last + 1]
        expected = posture_error_percent(steps[:, 0], steps[:, 1])
        assert error_percent(moments, first, last) == pytest.approx(expected)
    assert error_percent(moments, -5, 20) == error_percent(moments, 0, 20)
    assert np.isnan(error_percent(moments, 0, 0))


def test_with_all_modules_off_the_feedback_controller_is_left() -> None:
    episode = made()
    assert error_percent(run(episode), 0, 75) < 2.0
    episode.set_enabled_modules([False] * 3)
    episode.advance()
    moments = run(episode)
    assert error_percent(moments, 0, 75) > 5.0
    assert all(m.responsibility is not None and not m.responsibility.any() for m in moments[1:])


def test_an_agent_without_modules_has_none_to_switch_off() -> None:
    episode = made(agent="feedback_only")
    assert episode.enabled_modules is None
    assert run(episode)[5].responsibility is None
    with pytest.raises(BadOptionError, match="FeedbackOnly has no modules to switch off"):
        episode.set_enabled_modules([True])


def test_past_moments_are_posed_without_a_change_of_the_present() -> None:
    episode = made()
    advance(episode, 30)
    now = episode.data().qpos.copy()
    for index in (0, 12, 30):
        moment, data = episode.moments[index], episode.data(index)
        posture = (episode.env.physics.directions @ data.site_xpos).ravel()
        np.testing.assert_allclose(posture, moment.posture, atol=1e-12)
        positions = episode.hand_positions(index)
        assert positions is not None
        np.testing.assert_array_equal(positions, data.xipos[episode.env.physics.hand_ids])
    np.testing.assert_array_equal(episode.data().qpos, now)


@given(st.tuples(*[st.floats(-3, 3)] * 6))
def test_a_drag_pulls_towards_the_pointer_with_80_newtons_at_most(ends: Any) -> None:
    hand, pointer = np.array(ends[:3]), np.array(ends[3:])
    force, way = spring_force(hand, pointer), pointer - hand
    size, distance = np.linalg.norm(force), np.linalg.norm(way)
    assert size <= LARGEST_FORCE * (1 + 1e-12)
    assert size == pytest.approx(min(400.0 * distance, LARGEST_FORCE), abs=1e-6)
    assert force @ way == pytest.approx(size * distance, abs=1e-6)


@pytest.mark.parametrize("hand", [0, 1])
def test_a_hand_that_is_dragged_goes_to_the_pointer(hand: int) -> None:
    free, dragged = made(), made()
    pointer = np.array([0.2, 1.5 - 3.0 * hand, 1.0])
    for _ in range(75):
        free.advance()
        dragged.advance(dragged.pull(hand, pointer))
    assert np.linalg.norm(dragged.moments[-1].push[hand]) == pytest.approx(LARGEST_FORCE)
    assert not dragged.moments[-1].push[1 - hand].any()

    def mean_distance(episode: LiveEpisode) -> float:
        hands = [episode.hand_positions(index) for index in range(1, 76)]
        return float(
            np.mean([np.linalg.norm(at[hand] - pointer) for at in hands if at is not None])
        )

    assert mean_distance(dragged) < mean_distance(free) - 0.005
    assert error_percent(dragged.moments, 0, 75) > 1.5 * error_percent(free.moments, 0, 75)


def test_ideal_arms_cannot_be_pushed() -> None:
    episode = made(agent="feedback_only", arms="kinematic")
    assert episode.hand_positions() is None
    assert episode.pull(0, np.zeros(3)) is None


def test_arms_without_hands_cannot_be_pushed(tmp_path: Path) -> None:
    changes = ('name="left_hand"', 'name="left_tool"'), ('name="right_hand"', 'name="right_tool"')
    model = edited(tmp_path / "arms.xml", *changes)
    episode = made(agent="feedback_only", robot=str(model))
    assert episode.hand_positions() is None
    episode.advance(episode.pull(0, np.zeros(3)))
    assert episode.moments[-1].step == 1


def test_memory_of_a_moment_is_small() -> None:
    episode = made()
    run(episode)
    arrays = {}
    for moment in episode.moments:
        values = [*vars(moment).values(), *vars(moment.environment).values()]
        values += moment.environment.task.values()
        for value in values:
            if isinstance(value, np.ndarray):
                whole = value if value.base is None else value.base
                arrays[id(whole)] = whole.nbytes
    assert sum(arrays.values()) / len(episode.moments) < 4000


def test_the_past_has_the_payload_that_it_had() -> None:
    plants = (Plant(), Plant(payload=3.0))
    episode = made(0, agent="resolved_rate", plants=plants, switch_every=(0.5, 0.6))
    advance(episode, 30)
    on = [moment.plant for moment in episode.moments]
    episode.intervene(Intervention(payload=1.0))
    advance(episode, 1)
    now = len(episode.moments)
    light, heavy, by_hand = (episode.model(i) for i in (on.index(0), on.index(1), now))
    ball = heavy.geom("left_hand_payload").id
    assert [geom_colours(model)[ball, 3] for model in (light, heavy, by_hand)] == [0.0, 1.0, 1.0]
    assert heavy.geom_size[ball, 0] == pytest.approx(by_hand.geom_size[ball, 0] * 3.0 ** (1 / 3))
