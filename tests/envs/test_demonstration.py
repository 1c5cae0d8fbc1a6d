"""Demonstrations: noise, perturbations, random starts."""

from typing import Any

import dm_env
import numpy as np
import pytest
from dm_control.rl import control
from hypothesis import given, settings
from hypothesis import strategies as st

from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.kinematics import posture_from_angles
from mpma_mj.motions import ymca
from tests.robots.humanoid import (
    HUMANOID,
    check_limits,
    humanoid_limits,
    short_dance,
    without_two_arm,
)


def at_rest(env: dm_env.Environment, steps: int) -> list[dm_env.TimeStep]:
    return [env.reset()] + [env.step(np.zeros(8)) for _ in range(steps)]


@given(st.floats(0.1, 3.0), st.floats(5.0, 50.0))
@settings(max_examples=10)
def test_perturbations_have_their_rate_and_size(rate: float, size: float) -> None:
    demonstration = demonstration_of(repeats=200, perturbation=(rate, size))
    forces = demonstration.episode(0, 0).perturbations
    assert forces is not None
    seconds = len(forces) / demonstration.motion.rate
    lasting = 2  # steps of 0.05 s in a tenth of a second
    # Of a Poisson process: impulses of random direction add up like a random walk, also where
    # pushes meet.
    expected = rate * seconds * lasting * size**2
    assert (forces**2).sum() == pytest.approx(expected, rel=6.0 / np.sqrt(rate * seconds))
    sizes = np.linalg.norm(forces, axis=-1)
    alone = np.isclose(sizes, size)
    assert alone.sum() > 0.6 * (sizes > 0).sum()
    np.testing.assert_allclose(
        forces[alone].mean(axis=0), 0.0, atol=6 * size / np.sqrt(alone.sum())
    )
    assert abs((sizes[:, 0] > 0).mean() / (sizes > 0).any(axis=1).mean() - 0.5) < 0.3


def demonstration_of(**options: Any) -> Demonstration:
    return Demonstration(ymca(), EnvironmentOptions(**options), np.full(8, 12.0))


def test_a_perturbation_lasts_a_tenth_of_a_second_and_at_least_one_step() -> None:
    for rate, steps in ((20.0, 2), (50.0, 5), (4.0, 1)):
        motion = ymca(rate=rate)
        options = EnvironmentOptions(perturbation=(0.05, 1.0), repeats=100)
        forces = Demonstration(motion, options, np.full(8, 100.0)).episode(0, 0).perturbations
        assert forces is not None
        perturbed = np.concatenate([[0], (np.abs(forces).sum(axis=(1, 2)) > 0).astype(int), [0]])
        (begins,), (ends,) = np.where(np.diff(perturbed) == 1), np.where(np.diff(perturbed) == -1)
        assert len(begins) > 3
        assert np.median(ends - begins) == steps


def test_a_perturbation_moves_its_arm_only() -> None:
    env, calm = load("ymca", perturbation=(2.0, 100.0)), load("ymca")
    perturbed, left = at_rest(env, 60), at_rest(calm, 60)
    apart = np.array(
        [
            p.observation["posture"] - c.observation["posture"]
            for p, c in zip(perturbed, left, strict=True)
        ]
    ).reshape(-1, 2, 6)
    forces = env.task._drawn.perturbations[:60]
    first, hand = np.argwhere(np.linalg.norm(forces, axis=-1) > 0)[0]
    assert not apart[: first + 1].any()
    assert np.abs(apart[first + 1, hand]).max() > 0.01
    assert np.abs(apart[first + 1, 1 - hand]).max() < 1e-9


def test_random_starts_are_anywhere_with_posture_and_velocity_of_the_demonstration() -> None:
    env = load("ymca", random_start=True, reference_noise=0.0, repeats=2)
    starts = set()
    for _ in range(30):
        observation = env.reset().observation
        starts.add(env.task._step)
        np.testing.assert_allclose(observation["posture"], observation["reference"], atol=1e-9)
        moved = posture_from_angles(
            observation["joint_angles"] + 0.05 * observation["joint_velocities"]
        )
        np.testing.assert_allclose(moved, observation["target"], atol=1e-9)
    assert len(starts) > 20
    assert min(starts) >= 0
    assert max(starts) < env.task.steps


def test_an_episode_that_starts_later_ends_with_the_demonstration() -> None:
    env = load("ymca", random_start=True, repeats=1)
    env.reset()
    left = env.task.steps - env.task._step
    timesteps = at_rest_until_the_end(env)
    assert len(timesteps) == left
    assert timesteps[-1].discount == 1.0


def at_rest_until_the_end(env: dm_env.Environment) -> list[dm_env.TimeStep]:
    timesteps = [env.step(np.zeros(8))]
    while not timesteps[-1].last():
        timesteps.append(env.step(np.zeros(8)))
    return timesteps


def test_arms_start_no_faster_than_they_can_turn() -> None:
    options = EnvironmentOptions(random_start=True)
    slow = Demonstration(ymca(), options, np.full(8, 0.5))
    speeds = [np.abs(slow.start_of(slow.episode(0, number))[1]).max() for number in range(20)]
    assert max(speeds) == 0.5


def test_randomness_depends_on_seed_and_episode_alone() -> None:
    options = {"observation_noise": 0.1, "perturbation": (1.0, 10.0), "random_start": True}
    one, other = demonstration_of(**options), demonstration_of(**options)
    a, b, c = one.episode(5, 7), other.episode(5, 7), one.episode(5, 8)
    assert a.start == b.start
    for name in ("reference", "sensor_noise", "perturbations"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        assert not np.array_equal(getattr(a, name), getattr(c, name))
    # Nor on what else is asked for.
    plain = demonstration_of().episode(5, 7)
    np.testing.assert_array_equal(plain.reference, a.reference)


ARMS = ("physics", "kinematic")


@pytest.fixture(params=ARMS)
def env(request: pytest.FixtureRequest) -> control.Environment:
    return load("ymca", arms=request.param, seed=3)


def play(env: control.Environment, seed: int = 0, scale: float = 1.0) -> list[dm_env.TimeStep]:
    rng = np.random.default_rng(seed)
    timesteps = [env.reset()]
    while not timesteps[-1].last():
        timesteps.append(env.step(scale * rng.uniform(-1, 1, 8)))
    return timesteps


def test_reference_noise_has_its_size_and_keeps_unit_length() -> None:
    motion = ymca()
    env = load(motion, reference_noise=0.01, repeats=20)
    references = np.array([t.observation["reference"] for t in play(env)])
    error = references - np.tile(motion.posture, (20, 1))
    # Two of three directions keep their noise when vectors are made unit again.
    assert error.std() == pytest.approx(0.01 * np.sqrt(2 / 3), rel=0.03)
    np.testing.assert_allclose(np.linalg.norm(references.reshape(-1, 3), axis=1), 1.0)


def test_a_robot_returns_within_its_limits_by_postures_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion, limits = short_dance(), humanoid_limits()
    options = EnvironmentOptions(robot=HUMANOID, repeats=3, reference_noise=0.0)
    without_two_arm(monkeypatch)
    demonstration = Demonstration(motion, options, limits.max_speed, limits.kinematics)
    episode = demonstration.episode(0, 0)
    angles = episode.reference_angles
    assert angles is not None
    check_limits(angles, motion.rate)
    period, between = demonstration.period, 0
    for step, (now, shown) in enumerate(zip(angles[: 3 * period], episode.reference, strict=False)):
        if step % period < len(motion):
            np.testing.assert_array_equal(now, motion.joint_angles[step % period])
        elif step < 2 * period:
            between += 1
            np.testing.assert_allclose(shown, limits.kinematics.posture(now), atol=1e-9)
    assert between > 10
