"""Properties that dm_control's own suite is tested for, and those of imitation."""

import itertools
import unittest

import dm_env
import numpy as np
import pytest
from dm_control.rl import control
from dm_env import test_utils

from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError
from mpma_mj.feedback import feedback_action
from mpma_mj.motions import ymca

ARMS = ("physics", "kinematic")


@pytest.fixture(params=ARMS)
def env(request: pytest.FixtureRequest) -> control.Environment:
    return load("ymca", arms=request.param, seed=3)


class TestPhysicsConforms(test_utils.EnvironmentTestMixin, unittest.TestCase):
    def make_object_under_test(self) -> dm_env.Environment:
        return load("ymca", arms="physics", repeats=1)


class TestKinematicConforms(test_utils.EnvironmentTestMixin, unittest.TestCase):
    def make_object_under_test(self) -> dm_env.Environment:
        return load("ymca", arms="kinematic", repeats=1)


def play(env: control.Environment, seed: int = 0, scale: float = 1.0) -> list[dm_env.TimeStep]:
    rng = np.random.default_rng(seed)
    timesteps = [env.reset()]
    while not timesteps[-1].last():
        timesteps.append(env.step(scale * rng.uniform(-1, 1, 8)))
    return timesteps


def test_observations_fit_their_specs_and_are_finite(env: control.Environment) -> None:
    specs = env.observation_spec()
    for timestep in play(env):
        assert timestep.observation.keys() == specs.keys()
        for name, value in timestep.observation.items():
            specs[name].validate(value)
            assert np.isfinite(value).all()


def test_both_kinds_of_arms_have_the_same_specs() -> None:
    physics, kinematic = (load("ymca", arms=arms) for arms in ARMS)
    assert physics.observation_spec() == kinematic.observation_spec()
    assert physics.action_spec() == kinematic.action_spec()


def test_observations_vary(env: control.Environment) -> None:
    timesteps = play(env)
    for name in timesteps[0].observation:
        assert np.ptp([t.observation[name] for t in timesteps], axis=0).max() > 0.1


def test_observations_share_no_memory(env: control.Environment) -> None:
    one = env.reset().observation
    other = env.step(np.zeros(8)).observation
    for value in one.values():
        assert not any(np.shares_memory(value, later) for later in other.values())
    kept = {name: value.copy() for name, value in one.items()}
    for value in other.values():
        value[:] = 7.0
    env.step(np.ones(8))
    for name, value in kept.items():
        np.testing.assert_array_equal(one[name], value)


def test_an_overwritten_observation_does_not_change_the_demonstration(
    env: control.Environment,
) -> None:
    spoilt = env.reset().observation
    target = spoilt["target"].copy()
    spoilt["target"][:] = 9.0
    np.testing.assert_array_equal(env.step(np.zeros(8)).observation["reference"], target)


def test_rewards_are_bounded_and_their_terms_have_names(env: control.Environment) -> None:
    for timestep in play(env)[1:]:
        assert 0.0 <= timestep.reward <= 1.0
        terms = env.task.reward_terms(env.physics)
    assert set(terms) == {f"{s}_{p}" for s in ("left", "right") for p in ("upper_arm", "forearm")}
    assert timestep.reward == pytest.approx(np.mean(list(terms.values())))


def test_perfect_imitation_has_reward_one() -> None:
    env = load("ymca", reference_noise=0.0)
    env.reset()  # in the demonstrated posture
    assert env.task.get_reward(env.physics) == pytest.approx(1.0)


def test_equal_seeds_give_equal_episodes() -> None:
    for arms in ARMS:
        one, other = (play(load("ymca", arms=arms, seed=5)) for _ in range(2))
        for a, b in zip(one, other, strict=True):
            for name in a.observation:
                np.testing.assert_array_equal(a.observation[name], b.observation[name])
            assert a.reward == b.reward


def test_seeds_and_episodes_differ_in_their_noise() -> None:
    env = load("ymca", seed=0)
    first, second = (env.reset().observation["reference"] for _ in range(2))
    other = load("ymca", seed=1).reset().observation["reference"]
    assert not np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_setting_the_episode_repeats_it(env: control.Environment) -> None:
    first = env.reset().observation["target"]
    env.reset()
    env.task.episode = 0
    np.testing.assert_array_equal(env.reset().observation["target"], first)


@pytest.mark.parametrize("name", ["seed", "episode"])
@pytest.mark.parametrize("value", [None, -1, 1.5, "3", [1]], ids=repr)
def test_a_seed_or_episode_that_is_no_number_is_refused(name: str, value: object) -> None:
    env = load("ymca", arms="kinematic")
    setattr(env.task, name, value)
    with pytest.raises(BadOptionError, match=f"^{name} is .*; expected a whole number from 0 up$"):
        env.reset()


def test_the_target_is_the_next_reference(env: control.Environment) -> None:
    timesteps = play(env)
    for now, after in itertools.pairwise(timesteps):
        np.testing.assert_array_equal(now.observation["target"], after.observation["reference"])


def test_arms_start_in_the_demonstrated_posture(env: control.Environment) -> None:
    np.testing.assert_allclose(env.reset().observation["posture"], ymca().posture[0], atol=1e-9)


def test_the_end_of_the_demonstration_is_a_truncation(env: control.Environment) -> None:
    timesteps = play(env)
    assert len(timesteps) == 3 * len(ymca())
    assert timesteps[-1].last()
    assert timesteps[-1].discount == 1.0
    assert env.step(np.zeros(8)).first()


def test_divergence_ends_the_episode_with_discount_zero() -> None:
    env = load("ymca")
    env.reset()
    env.physics.data.qvel[0] = 1e12
    timestep = env.step(np.zeros(8))
    assert env.task.termination_reason.startswith("the simulation diverged")
    assert timestep.last()
    assert timestep.discount == 0.0
    assert timestep.reward == 0.0
    assert all(np.isfinite(value).all() for value in timestep.observation.values())
    assert env.reset().first()
    assert env.step(np.zeros(8)).mid()


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([0, 0, 0, np.nan, 0, 0, 0, 0], r"action\[3\] is nan; expected numbers in \[-1, 1\]"),
        ([0, np.inf, 0, 0, 0, 0, 0, 0], r"action\[1\] is inf"),
        (np.zeros(7), r"action has shape \(7,\); expected \(8,\)"),
        (np.zeros((1, 8)), r"action has shape \(1, 8\)"),
        (np.zeros(8, complex), "action is of type complex128; expected float64"),
        (["0"] * 8, "action is of type <U1"),
        (np.zeros(8, bool), "action is of type bool"),
        (None, "action is of type object"),
        ([[0, 1], [2]], "action is not an array"),
    ],
)
def test_invalid_actions_are_refused_and_change_nothing(
    env: control.Environment, action: object, message: str
) -> None:
    other = load("ymca", arms="kinematic" if "Kinematic" in str(env.physics) else "physics", seed=3)
    env.reset(), other.reset()
    with pytest.raises(BadOptionError, match=message):
        env.step(action)
    one, two = env.step(np.ones(8)), other.step(np.ones(8))
    np.testing.assert_array_equal(one.observation["posture"], two.observation["posture"])


def test_huge_actions_whole_numbers_and_float32_are_actions() -> None:
    env = load("ymca", arms="kinematic")
    for action in (np.full(8, 1e300), np.ones(8, np.float32), np.ones(8, int), [1] * 8):
        env.task.episode = 0
        env.reset()
        velocities = env.step(action).observation["joint_velocities"]
        np.testing.assert_allclose(velocities[:3], [12, 12, 20])


def test_actions_out_of_bounds_are_clipped() -> None:
    one, other = load("ymca", seed=0), load("ymca", seed=0)
    one.reset(), other.reset()
    np.testing.assert_array_equal(
        one.step(np.full(8, 5.0)).observation["posture"],
        other.step(np.ones(8)).observation["posture"],
    )


def test_kinematic_arms_clip_too() -> None:
    env = load("ymca", arms="kinematic")
    before = env.reset().observation["joint_angles"]
    after = env.step(np.array([-5.0, 0, 0, 0] * 2)).observation["joint_angles"]
    np.testing.assert_allclose((before - after)[::4], 12 * 0.05)


def test_context_and_reference_are_of_the_same_moment() -> None:
    motion = ymca()
    env = load(motion, reference_noise=0.0, repeats=1)
    for t, timestep in enumerate(play(env)):
        np.testing.assert_array_equal(timestep.observation["context"], motion.context[t])
        np.testing.assert_allclose(timestep.observation["reference"], motion.posture[t], atol=1e-12)


def test_arms_start_at_rest(env: control.Environment) -> None:
    play(env)
    np.testing.assert_array_equal(env.reset().observation["joint_velocities"], 0.0)


def test_action_one_is_the_joints_top_speed() -> None:
    env = load("ymca", arms="kinematic")
    before = env.reset().observation["joint_angles"]
    after = env.step(np.array([0.5, 0, 0, 0.2] * 2)).observation
    moved = (after["joint_angles"] - before) / 0.05
    np.testing.assert_allclose(moved, [6, 0, 0, 3] * 2, atol=1e-9)


def test_feedback_alone_tracks_on_both_kinds_of_arms(env: control.Environment) -> None:
    timestep, errors = env.reset(), []
    while not timestep.last():
        seen = timestep.observation
        action = feedback_action(
            seen["joint_angles"], seen["reference"], env.task.max_joint_speed, 0.05
        )
        timestep = env.step(action)
        errors.append(np.abs(timestep.observation["posture"] - timestep.observation["reference"]))
    assert 50 * np.mean(errors) < 3.0


@pytest.mark.parametrize("repeats", [1, 3])
def test_the_period_is_that_of_the_motion(repeats: int) -> None:
    task = load("ymca", repeats=repeats).task
    assert task.period == len(ymca())
    assert task.steps == repeats * len(ymca()) - 1
