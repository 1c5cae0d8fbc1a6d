"""Metrics of episodes, through every interface."""

import pickle
from typing import Any

import dm_env
import gymnasium
import numpy as np
import pytest

from mpma_mj import load, metrics
from mpma_mj.agents import RandomAgent, RandomConfig
from mpma_mj.envs.wrappers import (
    Evaluate,
    FeedbackAssist,
    GymEvaluate,
    GymFeedbackAssist,
    Wrapper,
)
from mpma_mj.training.rollout import record_epoch
from tests.envs.episodes import SPEC, Act, assert_same, at_random, danced, nothing, ymca


def test_overwritten_observations_change_nothing() -> None:
    def vandal(observation: dict[str, np.ndarray]) -> np.ndarray:
        for values in observation.values():
            values[:] = 0.0
        return np.zeros(8)

    env = Evaluate(FeedbackAssist(ymca()))
    rewards = [t.reward for t in danced(env, nothing)]
    assert [t.reward for t in danced_again(env, vandal)] == rewards
    assert env.episode_metrics[0] == env.episode_metrics[1]


def danced_again(env: dm_env.Environment, act: Act) -> list[dm_env.TimeStep]:
    env.task.episode = 0
    return danced(env, act)


def test_evaluating_changes_nothing() -> None:
    assert_same(danced(Evaluate(ymca()), at_random()), danced(ymca(), at_random()))


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_metrics_are_those_of_a_trace(arms: str) -> None:
    env = Evaluate(ymca(arms))
    trace = record_epoch(env, RandomAgent(RandomConfig(), SPEC, seed=3), 0)
    posture, reference = trace.posture[1:], trace.reference[1:]
    sites = env.physics.site_positions
    assert env.episode_metrics == [
        {
            "p_e_percent": metrics.posture_error_percent(posture, reference),
            "mpkpe_m": pytest.approx(metrics.mpkpe(sites(posture), sites(reference)), rel=1e-12),
            "mean_reward": float(np.mean(trace.reward)),
            "steps": len(posture),
            "terminated": False,
        }
    ]


def test_the_feedback_ratio_is_that_of_the_steps() -> None:
    assist = FeedbackAssist(ymca(), gain=0.5)
    env = Evaluate(Wrapper(assist))
    feedback, action = [], []
    act, timestep = at_random(), env.reset()
    while not timestep.last():
        timestep = env.step(0.3 * act({}))
        feedback.append(assist.last_feedback)
        action.append(assist.last_action)
    ratio = metrics.feedback_ratio(np.stack(feedback), np.stack(action))
    assert env.episode_metrics[0]["feedback_ratio"] == ratio
    assert 0.0 < ratio < 2.0
    danced(env, nothing)
    assert env.episode_metrics[1]["feedback_ratio"] == 1.0


def test_metrics_are_those_of_each_whole_episode() -> None:
    env = Evaluate(ymca("kinematic"))
    act = at_random()
    env.reset()
    for _ in range(5):
        env.step(act({}))
    assert env.episode_metrics == []
    danced(env, act)
    assert env.step(act({})).first()  # as dm_env has it: begins the next
    for _ in range(env.task.steps):
        timestep = env.step(act({}))
    assert timestep.last()
    assert [m["steps"] for m in env.episode_metrics] == [env.task.steps] * 2


def test_a_simulation_that_diverges_is_marked() -> None:
    env = Evaluate(ymca())
    env.reset()
    env.step(np.zeros(8))
    env.physics.data.qvel[:] = 1e12
    assert env.step(np.zeros(8)).last()
    assert env.episode_metrics[0]["terminated"]
    assert env.episode_metrics[0]["steps"] == 2


NAMES = ("TwoArmImitation-v0", "TwoArmImitationFlat-v0")


def actions(steps: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-0.3, 0.3, (steps, *shape, 8))


@pytest.mark.parametrize("name", NAMES)
def test_metrics_are_the_same_through_gymnasium(name: str) -> None:
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


def test_metrics_are_of_the_true_arms_not_of_noisy_observations() -> None:
    errors = []
    for noise in (0.0, 0.1):
        env = Evaluate(load("ymca", repeats=1, observation_noise=noise))
        timestep = env.reset()
        while not timestep.last():
            timestep = env.step(np.zeros(8))
        errors.append(env.episode_metrics[0]["p_e_percent"])
    assert errors[0] == errors[1]
