"""The help of the feedback controller, through every interface."""

import itertools
import pickle
import warnings
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from mpma_mj import load, make_vec
from mpma_mj.agents import AgentSpec, FeedbackOnly, FeedbackOnlyConfig
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.wrappers import (
    FeedbackAssist,
    GymEvaluate,
    GymFeedbackAssist,
    VectorFeedbackAssist,
)
from mpma_mj.errors import (
    BadOptionError,
)
from mpma_mj.feedback import feedback_action
from tests.envs.episodes import assert_same, at_random, danced, nothing, ymca
from tests.robots.humanoid import HUMANOID, short_dance, without_two_arm


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_assisted_zeros_are_feedback_alone(arms: str) -> None:
    env = ymca(arms)
    limits = {
        "max_joint_speed": env.task.max_joint_speed,
        "control_timestep": env.control_timestep(),
    }
    alone = danced(env, FeedbackOnly(FeedbackOnlyConfig(), AgentSpec(4, **limits)).act)
    assert_same(danced(FeedbackAssist(ymca(arms), gain=1.0), nothing), alone)


def test_assistance_of_gain_zero_changes_nothing() -> None:
    assert_same(danced(FeedbackAssist(ymca(), gain=0.0), at_random()), danced(ymca(), at_random()))


def test_assisted_actions_are_the_sum_clipped() -> None:
    env = FeedbackAssist(ymca(), gain=0.7)
    env.reset()
    for act in itertools.repeat(at_random(), 20):
        action = act({})
        env.step(action)
        expected = np.clip(action + env.last_feedback, -1.0, 1.0)
        np.testing.assert_array_equal(env.last_action, expected)
    assert (np.abs(env.last_feedback) <= 0.7).all()
    assert env.last_feedback.any()


@pytest.mark.parametrize("gain", [-0.1, 1.1, float("nan")])
def test_a_gain_out_of_bounds_is_refused(gain: float) -> None:
    with pytest.raises(BadOptionError, match="expected 0 to 1"):
        FeedbackAssist(ymca(), gain=gain)
    env = FeedbackAssist(ymca())
    with pytest.raises(BadOptionError, match="expected 0 to 1"):
        env.gain = gain


def test_other_robots_are_assisted_with_their_own_kinematics(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion = short_dance()
    options: dict[str, Any] = {"robot": HUMANOID, "repeats": 1}
    without_two_arm(monkeypatch)
    env = FeedbackAssist(load(motion, **options), 0.5)
    gym = GymFeedbackAssist(ImitationEnv(motion, **options), 0.5)
    seen, _ = env.reset().observation, gym.reset(seed=0)
    with closing(VectorFeedbackAssist(make_vec(1, motion, **options), 0.5)) as envs:
        envs.reset(seed=0)
        for action in actions(10):
            limits = env.task.max_joint_speed, env.control_timestep(), env.task.kinematics
            expected = 0.5 * feedback_action(
                seen["joint_angles"], seen["reference_angles"], *limits
            )
            seen = env.step(action).observation
            np.testing.assert_array_equal(env.last_feedback, expected)
            np.testing.assert_array_equal(gym.step(action)[4]["feedback"], expected)
            np.testing.assert_array_equal(envs.step(action[None])[4]["feedback"][0], expected)


NAMES = ("TwoArmImitation-v0", "TwoArmImitationFlat-v0")


def actions(steps: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-0.3, 0.3, (steps, *shape, 8))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("gain", [0.0, 0.6, 1.0])
def test_the_assist_is_the_same_through_gymnasium(name: str, gain: float) -> None:
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


def test_overwritten_observations_change_nothing() -> None:
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
            with pytest.raises(BadOptionError, match=r"expected an environment of gymnasium\.make"):
                wrapper(other)
    for other in (pendulum, ours, load("ymca")):
        with pytest.raises(BadOptionError, match=r"expected an environment of mpma_mj\.make_vec"):
            VectorFeedbackAssist(other)
    for gain in (2.0, "much", None, True, 10**400, np.nan):
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


def test_clipped_entries_are_counted_with_the_assist_too() -> None:
    env = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}"), 0.0)
    assist = FeedbackAssist(load("ymca"), 0.0)
    env.reset(), assist.reset()
    action = np.array([0, 2.0, 0, -3.0, 0, 0, 0, 0])
    assert env.step(action)[4]["clipped"] == 2
    assist.step(action)
    assert assist.task.clipped == 2


def test_gymnasiums_checker_finds_nothing() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for usual in ("different from the unwrapped version", "space .* value is -?infinity"):
            warnings.filterwarnings("ignore", message=f".*{usual}")
        inner = gymnasium.make(f"mpma_mj:{NAMES[0]}").unwrapped
        for wrapped in (GymFeedbackAssist(inner), GymEvaluate(inner)):
            check_env(wrapped, skip_render_check=True)


@pytest.mark.parametrize("action", [np.zeros(7), np.full(8, np.nan), None])
def test_invalid_actions_are_refused_by_the_assist_too(action: Any) -> None:
    gym = GymFeedbackAssist(gymnasium.make(f"mpma_mj:{NAMES[0]}", disable_env_checker=True))
    dm = FeedbackAssist(load("ymca"))
    for env in (gym, dm):
        env.reset()
        with pytest.raises(BadOptionError, match="action"):
            env.step(action)
