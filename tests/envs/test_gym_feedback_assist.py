"""The feedback controller's help through Gymnasium is that of `FeedbackAssist`."""

import pickle
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

from mpma_mj import load, make_vec
from mpma_mj.envs.wrappers import FeedbackAssist, GymFeedbackAssist, VectorFeedbackAssist
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
    with pytest.raises(BadOptionError, match="expected one of TwoArmImitation, or of make_vec"):
        GymFeedbackAssist(pendulum)
    with pytest.raises(BadOptionError, match="gain is 2; expected 0 to 1"):
        GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}"), 2.0)


@pytest.mark.parametrize("action", [np.zeros(7), np.full(8, np.nan), None])
def test_actions_that_are_none_are_refused_with_help_too(action: Any) -> None:
    gym = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}", disable_env_checker=True))
    dm = FeedbackAssist(load("ymca"))
    for env in (gym, dm):
        env.reset()
        with pytest.raises(BadOptionError, match="action"):
            env.step(action)
