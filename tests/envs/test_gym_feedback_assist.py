"""The feedback controller's help through Gymnasium is that of `FeedbackAssist`."""

import pickle
import warnings
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from mpma_mj import load, make_vec
from mpma_mj.envs.wrappers import (
    Evaluate,
    FeedbackAssist,
    GymEvaluate,
    GymFeedbackAssist,
    VectorFeedbackAssist,
)
from mpma_mj.errors import BadOptionError

NAMES = ("TwoArmImitation-v0", "TwoArmImitationFlat-v0")


def actions(steps: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-0.3, 0.3, (steps, *shape, 8))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("gain", [0.0, 0.6, 1.0])
def test_one_environment_is_assisted_as_by_the_other_face(name: str, gain: float) -> None:
    env = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{name}", seed=2), gain)
    plain = FeedbackAssist(load("ymca", seed=2), gain)
    env.reset(seed=2), plain.reset()
    for action in actions(60):
        _, reward, _, _, info = env.step(action)
        assert reward == plain.step(action).reward
        np.testing.assert_array_equal(info["feedback"], plain.last_feedback)


@pytest.mark.parametrize("flat", [False, True])
def test_many_environments_are_assisted_each_as_alone(flat: bool) -> None:
    singles = [FeedbackAssist(load("ymca", seed=5 + i, repeats=1), 0.5) for i in range(3)]
    for single in singles:
        single.reset()
    with closing(VectorFeedbackAssist(make_vec(3, repeats=1, seed=5, flat=flat), 0.5)) as envs:
        envs.reset()
        for action in actions(200, 3):
            _, rewards, _, _, info = envs.step(action)
            for i, single in enumerate(singles):
                timestep = single.step(action[i])
                assert rewards[i] == (timestep.reward or 0.0)
                if not timestep.first():
                    np.testing.assert_array_equal(info["feedback"][i], single.last_feedback)


def test_what_an_agent_writes_into_observations_is_no_matter() -> None:
    env, other = (GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}")) for _ in range(2))
    spoilt, _ = env.reset(seed=0)
    other.reset(seed=0)
    for action in actions(10):
        for values in spoilt.values():
            values[:] = 0.0
        spoilt, reward, *_ = env.step(action)
        assert reward == other.step(action)[1]


def test_a_pickle_goes_on_identically() -> None:
    env = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[1]}"), 0.7)
    env.reset(seed=0)
    played = actions(20)
    for action in played[:10]:
        env.step(action)
    other = pickle.loads(pickle.dumps(env))
    for action in played[10:]:
        one, two = env.step(action), other.step(action)
        np.testing.assert_array_equal(one[0], two[0])
        np.testing.assert_array_equal(one[4]["feedback"], two[4]["feedback"])


def test_other_environments_and_gains_are_refused() -> None:
    pendulum: Any = gymnasium.make("Pendulum-v1")
    ours, many = gymnasium.make(f"mpma_mj:{NAMES[0]}"), make_vec(2)
    for other in (pendulum, many, load("ymca")):
        for wrapper in (GymFeedbackAssist, GymEvaluate):
            with pytest.raises(BadOptionError, match=r"expected what gymnasium\.make"):
                wrapper(other)
    for other in (pendulum, ours, load("ymca")):
        with pytest.raises(BadOptionError, match=r"expected what mpma_mj\.make_vec"):
            VectorFeedbackAssist(other)
    for gain in (2.0, "much", None, True):
        with pytest.raises(BadOptionError, match=r"gain is .*; expected 0 to 1"):
            GymFeedbackAssist(ours, gain)
        with pytest.raises(BadOptionError, match=r"gain is .*; expected 0 to 1"):
            GymFeedbackAssist(ours).gain = gain
    many.close()


def test_the_gain_may_be_changed_at_any_time() -> None:
    env = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}"), 1.0)
    with closing(VectorFeedbackAssist(make_vec(1), 1.0)) as envs:
        env.reset(seed=0), envs.reset(seed=0)
        for gain in (1.0, 0.25):
            env.gain = envs.gain = gain
            one = env.step(np.zeros(8))[4]["feedback"]
            (other,) = envs.step(np.zeros((1, 8)))[4]["feedback"]
            np.testing.assert_array_equal(one, other)
            assert 0.0 < np.abs(one).max() <= gain


def test_entries_beyond_the_bounds_are_counted_with_help_too() -> None:
    env = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}"), 0.0)
    assist = FeedbackAssist(load("ymca"), 0.0)
    env.reset(), assist.reset()
    action = np.array([0, 2.0, 0, -3.0, 0, 0, 0, 0])
    assert env.step(action)[4]["clipped"] == 2
    assist.step(action)
    assert assist.task.clipped == 2


def test_gymnasiums_checker_has_nothing_to_say() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version")
        inner = gymnasium.make(f"mpma_mj:{NAMES[0]}").unwrapped
        for wrapped in (GymFeedbackAssist(inner), GymEvaluate(inner)):
            check_env(wrapped, skip_render_check=True)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_measured_is_what_the_other_face_measures(name: str) -> None:
    options: dict[str, Any] = {"repeats": 1, "observation_noise": 0.05, "seed": 2}
    env = GymEvaluate(GymFeedbackAssist(gymnasium.make(f"mpma_mj:{name}", **options), 0.5))
    plain = Evaluate(FeedbackAssist(load("ymca", **options), 0.5))
    env.reset(seed=2)
    timestep, truncated = plain.reset(), False
    played = iter(actions(1000))
    while not timestep.last():
        action = next(played)
        timestep = plain.step(action)
        truncated = env.step(action)[3]
    assert truncated
    assert env.episode_metrics == plain.episode_metrics
    assert plain.episode_metrics[0]["feedback_ratio"] > 0.0


def test_a_pickled_evaluation_continues_identically() -> None:
    env = GymEvaluate(gymnasium.make(f"mpma_mj:{NAMES[0]}", motion="ymca", repeats=1))
    env.reset(seed=0)
    played = iter(actions(1000))
    for _ in range(10):
        env.step(next(played))
    other = pickle.loads(pickle.dumps(env))
    for action in played:
        other.step(action)
        if env.step(action)[3]:
            break
    assert len(env.episode_metrics) == 1
    assert other.episode_metrics == env.episode_metrics


def test_steps_after_the_end_do_not_count_twice() -> None:
    env = GymEvaluate(gymnasium.make(f"mpma_mj:{NAMES[0]}", max_episode_steps=10))
    env.reset(seed=0)
    for _ in range(11):
        env.step(np.zeros(8))
    assert [row["steps"] for row in env.episode_metrics] == [10, 1]


def test_measures_are_of_the_true_arms_not_of_what_is_observed() -> None:
    errors = []
    for noise in (0.0, 0.1):
        env = Evaluate(load("ymca", repeats=1, observation_noise=noise))
        timestep = env.reset()
        while not timestep.last():
            timestep = env.step(np.zeros(8))
        errors.append(env.episode_metrics[0]["p_e_percent"])
    assert errors[0] == errors[1]


@pytest.mark.parametrize("action", [np.zeros(7), np.full(8, np.nan), None])
def test_actions_that_are_none_are_refused_with_help_too(action: Any) -> None:
    gym = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}", disable_env_checker=True))
    dm = FeedbackAssist(load("ymca"))
    for env in (gym, dm):
        env.reset()
        with pytest.raises(BadOptionError, match="action"):
            env.step(action)
