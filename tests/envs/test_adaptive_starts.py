"""Adaptive starts: weights of sections, one and many, copies."""

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from dm_control.rl import control

from mpma_mj.envs.adaptive_starts import AdaptiveStarts
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca

ADAPTIVE: dict[str, Any] = {"random_start": "adaptive"}
SECTIONS = 16


def demonstration() -> Demonstration:
    return Demonstration(ymca(), EnvironmentOptions(), np.full(8, 12.0))


def sections(steps: Any, period: int) -> Any:
    return np.asarray(steps) % period * SECTIONS // period


def start_of_next(env: control.Environment) -> int:
    """Begin an episode and return where, by its noiseless reference."""
    env.reset()
    return int(np.argmin([np.abs(env.task.reference - x).sum() for x in env.task.motion.posture]))


def test_before_any_error_is_known_starts_are_uniform() -> None:
    shown = demonstration()
    starts = [AdaptiveStarts(1, shown).begin(0, seed, 0) for seed in range(800)]
    assert min(starts) >= 0
    assert max(starts) < shown.steps
    found = np.bincount(sections(starts, shown.period), minlength=SECTIONS)
    assert found.min() > 20
    assert found.max() < 90


def test_the_share_of_a_section_where_reward_is_missed_rises_and_of_none_vanishes() -> None:
    shown = demonstration()
    made, moved = AdaptiveStarts(1, shown), np.ones(1, bool)
    starts = [made.begin(0, 7, 0)]
    for episode in range(1, 400):
        for step in range(starts[-1] + 1, shown.steps + 1):
            fails = sections(step, shown.period) == 5
            made.record(np.array([step]), np.array([0.0 if fails else 1.0]), moved)
        starts.append(made.begin(0, 7, episode))
    shares = np.bincount(sections(starts[50:], shown.period), minlength=SECTIONS) / 350
    assert shares[5] > 0.7  # 1.0125 of 1.2 by the weights
    assert np.delete(shares, 5).max() < 0.05


def test_without_errors_all_sections_stay_equal() -> None:
    shown = demonstration()
    made = AdaptiveStarts(1, shown)
    for step in range(1, shown.steps + 1):
        made.record(np.array([step]), np.ones(1), np.ones(1, bool))
    starts = []
    for episode in range(1, 400):
        starts.append(made.begin(0, 0, episode))
    assert len(set(sections(starts, shown.period))) == SECTIONS


def test_environments_that_took_no_step_are_left_out() -> None:
    shown = demonstration()
    one, many = AdaptiveStarts(1, shown), AdaptiveStarts(2, shown)
    rng = np.random.default_rng(0)
    for step in range(1, 60):
        rewards = rng.uniform(size=2)
        one.record(np.array([step]), rewards[:1], np.ones(1, bool))
        many.record(np.array([step, 3]), rewards, np.array([True, False]))
    assert [one.begin(0, 4, k) for k in range(1, 9)] == [many.begin(0, 4, k) for k in range(1, 9)]
    fresh = AdaptiveStarts(2, shown)
    assert many.begin(1, 4, 1) == fresh.begin(1, 4, 1)


def test_a_policy_that_fails_in_one_place_starts_there_more_often() -> None:
    shares = {}
    for random_start in (True, "adaptive"):
        env = load(
            "ymca", arms="kinematic", repeats=1, random_start=random_start, error_observation=True,
            reference_noise=0.0,
        )  # fmt: skip
        starts = []
        for _ in range(150):
            starts.append(start_of_next(env))
            timestep, step = env.step(np.zeros(8)), starts[-1] + 1
            while not timestep.last():
                good = sections(step, env.task.period) < SECTIONS // 2
                move = timestep.observation["move"].clip(-1.0, 1.0)
                timestep, step = env.step(move if good else np.zeros(8)), step + 1
        late = sections(starts, env.task.period) >= SECTIONS // 2
        shares[random_start] = np.mean(late[30:])
    assert shares["adaptive"] > shares[True] + 0.2


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"arms": "kinematic", "termination_distance": 0.3},
        {"payload": (0, 3), "latency": (0, 2), "reward_weights": {"left_forearm": 3.0}},
    ],
    ids=["physics", "kinematic", "randomised"],
)
def test_each_of_many_is_a_single_environment_bit_for_bit(options: dict[str, Any]) -> None:
    options = {"repeats": 1, **ADAPTIVE, **options}
    singles = [load("ymca", seed=4 + i, **options) for i in range(3)]
    envs = make_vec(3, "ymca", seed=4, **options)
    observations, _ = envs.reset()
    timesteps = [single.reset() for single in singles]
    rng = np.random.default_rng(1)
    for _ in range(400):
        for i, timestep in enumerate(timesteps):
            for name, values in timestep.observation.items():
                np.testing.assert_array_equal(observations[name][i], values)
        action = rng.uniform(-1.0, 1.0, (3, 8))
        observations, rewards, *_ = envs.step(action)
        timesteps = [one.step(own) for one, own in zip(singles, action, strict=True)]
        assert rewards.tolist() == [timestep.reward or 0.0 for timestep in timesteps]
    assert envs.episode.min() > 5
    envs.close()


def test_a_seed_forgets_earlier_episodes() -> None:
    env = ImitationEnv("ymca", repeats=1, **ADAPTIVE)

    def starts() -> list[bytes]:
        found = [env.reset(seed=9)[0]["posture"].tobytes()]
        for _ in range(6):
            over = False
            while not over:
                *_, terminated, truncated, _ = env.step(np.zeros(8))
                over = terminated or truncated
            found.append(env.reset()[0]["posture"].tobytes())
        return found

    assert starts() == starts()


def test_a_copy_of_gymnasiums_environment_has_the_same_weights() -> None:
    env = ImitationEnv("ymca", repeats=1, **ADAPTIVE)
    env.reset(seed=3)
    for step in range(150):
        if env.step(np.full(8, 0.3))[3]:
            env.reset()
        if step in (70, 149):
            others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    expected = [env.reset()[0]["posture"] for _ in range(3)]
    for other in others:
        for posture in expected:
            np.testing.assert_array_equal(other.reset()[0]["posture"], posture)


@pytest.mark.parametrize("given", ["adaptiv", 1, None])
def test_other_starts_are_refused_in_one_line(given: Any) -> None:
    for make in (load, lambda *words, **options: make_vec(2, *words, **options)):
        with pytest.raises(BadOptionError) as caught:
            make("ymca", random_start=given)
        assert (
            str(caught.value) == f"random_start is {given!r}; expected True or False, or adaptive"
        )
