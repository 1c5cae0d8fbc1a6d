"""Reward: weights, bounds, and its value at a known distance."""

import itertools

import dm_env
import numpy as np
import pytest
from dm_control.rl import control

from mpma_mj.envs.load import load
from mpma_mj.envs.reward import mean_reward, reward_weights
from mpma_mj.kinematics import SEGMENT_NAMES


def at_rest(env: dm_env.Environment, steps: int) -> list[dm_env.TimeStep]:
    return [env.reset()] + [env.step(np.zeros(8)) for _ in range(steps)]


def test_no_reward_is_above_one_with_any_weights() -> None:
    for weights in itertools.product((1.0, 2.0, 3.0, 4.0, 1e6), repeat=4):
        named = dict(zip(SEGMENT_NAMES, weights, strict=True))
        assert 1.0 - 1e-12 < mean_reward(np.ones(4), reward_weights(named)) <= 1.0


def test_the_reward_is_the_weighted_mean_of_its_terms() -> None:
    weights = {"left_forearm": 3.0, "right_forearm": 0.0}
    env = load("ymca", reward_weights=weights)
    timestep = at_rest(env, 20)[-1]
    terms = env.task.reward_terms(env.physics)
    full = dict.fromkeys(terms, 1.0) | weights
    expected = np.average(list(terms.values()), weights=list(full.values()))
    assert timestep.reward == pytest.approx(expected)
    assert len(set(terms.values())) == 4


ARMS = ("physics", "kinematic")


@pytest.fixture(params=ARMS)
def env(request: pytest.FixtureRequest) -> control.Environment:
    return load("ymca", arms=request.param, seed=3)


def test_rewards_are_a_tenth_at_half_a_unit_from_the_reference() -> None:
    env = load("ymca", reference_noise=0.05)
    env.reset()
    for _ in range(5):
        timestep = env.step(np.zeros(8))
    seen = timestep.observation
    distance = np.linalg.norm((seen["posture"] - seen["reference"]).reshape(4, 3), axis=1)
    assert timestep.reward == pytest.approx(np.mean(0.1 ** ((distance / 0.5) ** 2)))
