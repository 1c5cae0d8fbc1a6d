"""Conventions of dm_control: its suite's wrappers, its generator, Shimmy's seeds."""

import copy
import warnings
from typing import Any

import dm_env
import numpy as np
import pytest
from dm_control.suite.wrappers import action_noise, action_scale, pixels

from mpma_mj.envs.load import load
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer


def play(env: dm_env.Environment, steps: int = 10) -> list[dm_env.TimeStep]:
    return [env.reset(), *(env.step(np.full(8, 0.3)) for _ in range(steps))]


def test_noise_on_actions_follows_from_the_seed() -> None:
    def rewards(seed: int) -> list[float]:
        env = action_noise.Wrapper(load("ymca", repeats=1, seed=seed), 0.1)
        return [timestep.reward for timestep in play(env)[1:]]

    assert rewards(3) == rewards(3)
    assert rewards(3) != rewards(4)
    assert rewards(3) != [timestep.reward for timestep in play(load("ymca", repeats=1, seed=3))[1:]]


def test_the_generator_of_wrappers_draws_nothing_for_the_task() -> None:
    used, unused = load("ymca", repeats=1, seed=3), load("ymca", repeats=1, seed=3)
    used.task.random.normal(size=100)
    assert [t.reward for t in play(used)] == [t.reward for t in play(unused)]


@pytest.mark.parametrize("seed", [0, 2**40])
def test_seeds_of_any_size_have_a_generator(seed: int) -> None:
    assert isinstance(load("ymca", seed=seed).task.random, np.random.RandomState)


def test_actions_can_be_rescaled() -> None:
    env = action_scale.Wrapper(load("ymca", repeats=1), -2.0, 2.0)
    plain = load("ymca", repeats=1)
    env.reset(), plain.reset()
    assert env.step(np.ones(8)).reward == plain.step(np.full(8, 0.5)).reward


@pytest.mark.usefixtures("opengl")
def test_pixels_can_be_observed() -> None:
    view = {"width": 80, "height": 60, "camera_id": "front"}
    env = pixels.Wrapper(load("ymca", repeats=1), pixels_only=False, render_kwargs=view)
    first, *_, last = (timestep.observation for timestep in play(env))
    assert set(first) == {*load("ymca").observation_spec(), "pixels"}
    assert first["pixels"].shape == (60, 80, 3)
    assert (first["pixels"] != last["pixels"]).any()
    env.physics.free()


@pytest.mark.usefixtures("opengl")
def test_pictures_show_the_reward_only_if_asked_to() -> None:
    physics = PhysicsArms.make()
    renderer = ArmRenderer(physics, width=160, height=120)

    def colour(brightness: float) -> float:
        physics.set_brightness(brightness)
        picture = renderer.picture().astype(int)
        return float(np.ptp(picture, axis=-1).mean())

    plain = np.ptp(renderer.picture().astype(int), axis=-1).mean()
    assert colour(1.0) == pytest.approx(plain, rel=0.02)
    assert colour(0.0) < colour(0.9) < colour(1.0)
    renderer.close()
    env = load("ymca", repeats=1)
    play(env)
    before = env.physics.model.geom_rgba.copy()
    env.task.visualize_reward = True
    play(env)
    assert (env.physics.model.geom_rgba != before).any()


def test_a_new_generator_starts_the_first_episode_of_another_seed() -> None:
    env = load("ymca", repeats=1)

    def targets(generator: np.random.RandomState) -> list[Any]:
        env.task._random = generator
        return [env.reset().observation["target"] for _ in range(2)]

    first, second = targets(np.random.RandomState(3))
    np.testing.assert_array_equal(targets(np.random.RandomState(3)), [first, second])
    assert not np.array_equal(first, second)
    assert not np.array_equal(targets(np.random.RandomState(4))[0], first)
    generator = np.random.RandomState(5)
    untouched = copy.deepcopy(generator)
    env.task._random = generator
    assert env.task.random.randint(1000) == untouched.randint(1000)


def test_shimmys_seeds_start_episodes() -> None:
    shimmy = pytest.importorskip("shimmy.dm_control_compatibility")
    from gymnasium.utils.env_checker import check_env

    env = shimmy.DmControlCompatibilityV0(load("ymca", repeats=1))
    first, again, other = (env.reset(seed=seed)[0] for seed in (3, 3, 4))
    for name, values in first.items():
        np.testing.assert_array_equal(again[name], values)
    assert not np.array_equal(other["target"], first["target"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of unbounded spaces and a render mode without a display
        check_env(env, skip_render_check=True)
