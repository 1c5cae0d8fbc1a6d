"""Rules of a step: delay, endings, and that many are as one."""

from typing import Any

import dm_env
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.step_rules import (
    DIVERGED,
    OVER,
    TOO_FAR,
    StepRules,
    count_clipped,
    delayed,
    top_speeds,
)
from mpma_mj.kinematics import JOINT_NAMES, posture_from_angles

RNG = np.random.default_rng
SPEEDS, LENGTHS = np.full(8, 12.0), np.full(4, 0.3)


def rules(distance: float | None = 0.3, steps: int = 50) -> StepRules:
    options = EnvironmentOptions(
        termination_distance=distance, reward_weights={"left_forearm": 2.0}
    )
    return StepRules(options, steps, SPEEDS, LENGTHS)


@given(st.integers(0, 2**32 - 1), st.sampled_from([None, 0.3]))
def test_the_outcome_of_many_is_that_of_each_alone(seed: int, distance: float | None) -> None:
    rng = RNG(seed)
    posture, reference = posture_from_angles(rng.uniform(0.0, 1.0, (2, 3, 5, 8)))
    step = rng.integers(40, 60, (3, 5))
    diverged, begins = rng.random((2, 3, 5)) < 0.2
    diverged &= ~begins
    of = rules(distance).outcome
    many = of(posture, reference, step, diverged, begins)
    for row in np.ndindex(3, 5):
        alone = of(posture[row], reference[row], step[row], diverged[row], begins[row])
        for values, value in zip(many, alone, strict=True):
            np.testing.assert_array_equal(values[row], value)
        assert many.termination_reason[row] == alone.termination_reason
        assert many.truncated[row] == alone.truncated


def test_an_episode_ends_for_the_first_reason_that_holds() -> None:
    near, far = posture_from_angles(np.array([np.zeros(8), np.full(8, 1.0)]))
    yes, no = np.True_, np.False_
    for posture, step, diverged, begins, reason in (
        (far, 50, yes, no, DIVERGED),
        (far, 50, no, no, TOO_FAR),
        (near, 50, no, no, OVER),
        (near, 49, no, no, ""),
        (far, 50, no, yes, ""),
    ):
        outcome = rules().outcome(posture, near, np.intp(step), diverged, begins)
        assert outcome.termination_reason == reason
        assert outcome.terminated == (reason in (DIVERGED, TOO_FAR))
        assert outcome.truncated == (reason == OVER)
        assert outcome.ended == (reason != "")
        assert (outcome.reward == 0.0) == bool(diverged or begins)


@given(st.integers(0, 5), st.sampled_from([(), (3,), (2, 2)]))
def test_an_action_takes_effect_after_the_latency(latency: int, batch: tuple[int, ...]) -> None:
    actions = RNG(0).uniform(-1.0, 1.0, (12, *batch, 8))
    pending = np.zeros((latency, *batch, 8))
    effective = []
    for action in actions:
        due, pending = delayed(pending, action)
        effective.append(due)
    np.testing.assert_array_equal(effective[:latency], 0.0)
    np.testing.assert_array_equal(effective[latency:], actions[: 12 - latency])


def test_only_the_locked_joint_has_no_top_speed() -> None:
    np.testing.assert_array_equal(top_speeds(SPEEDS, JOINT_NAMES, None), SPEEDS)
    for number, name in enumerate(JOINT_NAMES):
        assert np.flatnonzero(top_speeds(SPEEDS, JOINT_NAMES, name) == 0.0).tolist() == [number]


def test_clipped_entries_are_counted_for_each_of_many() -> None:
    actions = np.zeros((2, 3, 8))
    actions[0, 1, :2], actions[1, 2, 7], actions[0, 0] = (-1.5, 1.5), 2.0, 1.0
    np.testing.assert_array_equal(count_clipped(actions), [[0, 2, 0], [0, 0, 1]])
    np.testing.assert_array_equal(rules().joint_velocities(actions)[1, 2, 7], 12.0)


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
@pytest.mark.parametrize("latency", [1, 3])
def test_latency_delays_the_effect_on_the_arms(arms: Any, latency: int) -> None:
    plain, late = load("ymca", arms=arms), load("ymca", arms=arms, latency=latency)
    rng = np.random.default_rng(0)
    actions = list(rng.uniform(-1, 1, (10, 8)))
    plain.reset(), late.reset()
    for action in [np.zeros(8)] * latency + actions:
        expected = plain.step(action).observation["posture"]
    for action in actions + [np.ones(8)] * latency:  # what is pending at the end has no effect
        got = late.step(action).observation["posture"]
    np.testing.assert_array_equal(got, expected)


def test_a_pending_action_is_not_changed_by_its_giver() -> None:
    env, action = load("ymca", arms="kinematic", latency=1), np.full(8, 0.25)
    env.reset()
    env.step(action)
    action[:] = -1.0
    velocities = env.step(action).observation["joint_velocities"]
    np.testing.assert_allclose(velocities[:3], 0.25 * env.task.max_joint_speed[:3])


def test_no_action_is_pending_where_an_episode_begins() -> None:
    env = load("ymca", arms="kinematic", latency=2)
    for _ in range(2):
        start = env.reset().observation["joint_angles"]
        np.testing.assert_array_equal(env.step(np.ones(8)).observation["joint_angles"], start)


def at_rest_until_the_end(env: dm_env.Environment) -> list[dm_env.TimeStep]:
    timesteps = [env.step(np.zeros(8))]
    while not timesteps[-1].last():
        timesteps.append(env.step(np.zeros(8)))
    return timesteps


@given(st.floats(0.05, 0.5))
def test_episodes_end_at_the_termination_distance(distance: float) -> None:
    env = load("ymca", arms="kinematic", termination_distance=distance, repeats=1)
    env.reset()
    sites = env.physics.site_positions

    def farthest(timestep: dm_env.TimeStep) -> float:
        seen = timestep.observation
        offset = sites(seen["posture"]) - sites(seen["reference"])
        return float(np.linalg.norm(offset, axis=-1).max())

    *before, last = at_rest_until_the_end(env)
    assert all(farthest(timestep) <= distance for timestep in before)
    assert farthest(last) > distance
    assert last.discount == 0.0
    assert last.reward > 0.0
    assert env.reset().first()
    assert env.task.termination_reason == ""
