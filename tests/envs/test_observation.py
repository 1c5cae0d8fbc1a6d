"""Observations: noise, lookahead, phase."""

import dataclasses
from typing import Any

import dm_env
import numpy as np
import pytest

from mpma_mj.envs.load import load
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.errors import RecordingWarning
from mpma_mj.feedback import followed, joint_error
from mpma_mj.kinematics import wrap
from mpma_mj.motions import ymca


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_observation_noise_has_its_size_and_leaves_the_arms_alone(arms: Any) -> None:
    env, exact = load("ymca", arms=arms, observation_noise=0.02), load("ymca", arms=arms)
    rng = np.random.default_rng(1)
    seen, true = [env.reset()], [exact.reset()]
    while not seen[-1].last():
        action = rng.uniform(-0.2, 0.2, 8)
        seen.append(env.step(action)), true.append(exact.step(action))
        assert seen[-1].reward == true[-1].reward

    def off(name: str) -> np.ndarray:
        pairs = zip(seen, true, strict=True)
        return np.array([s.observation[name] - t.observation[name] for s, t in pairs])

    assert off("joint_angles").std() == pytest.approx(0.02, rel=0.05)
    velocity = off("joint_velocities") / env.task.max_joint_speed
    assert velocity.std() == pytest.approx(0.02, rel=0.05)
    # Unit vectors keep the noise of two of three directions.
    assert off("posture").std() == pytest.approx(0.02 * np.sqrt(2 / 3), rel=0.05)
    vectors = np.array([t.observation["posture"] for t in seen]).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0)
    for name in ("reference", "target", "context"):
        assert not off(name).any()


def at_rest_until_the_end(env: dm_env.Environment) -> list[dm_env.TimeStep]:
    timesteps = [env.step(np.zeros(8))]
    while not timesteps[-1].last():
        timesteps.append(env.step(np.zeros(8)))
    return timesteps


def test_lookahead_contains_the_next_targets() -> None:
    env = load("ymca", lookahead=5, repeats=1)
    assert env.observation_spec()["lookahead"].shape == (5, 12)
    timesteps = [env.reset(), *at_rest_until_the_end(env)]
    references = np.array([t.observation["reference"] for t in timesteps])
    for now, timestep in enumerate(timesteps):
        lookahead = timestep.observation["lookahead"]
        np.testing.assert_array_equal(lookahead[0], timestep.observation["target"])
        shown = references[np.minimum(now + 1 + np.arange(5), len(references) - 1)]
        np.testing.assert_array_equal(lookahead, shown)


def test_phase_goes_round_once_a_repetition() -> None:
    env = load("ymca", phase=True)
    timesteps = [env.reset(), *at_rest_until_the_end(env)]
    phase = np.array([t.observation["phase"] for t in timesteps])
    np.testing.assert_allclose(np.linalg.norm(phase, axis=1), 1.0)
    turn = np.unwrap(np.arctan2(phase[:, 0], phase[:, 1]))
    np.testing.assert_allclose(turn, 2 * np.pi * np.arange(len(turn)) / env.task.period, atol=1e-9)


@pytest.mark.parametrize("motion", ["ymca", "synthetic-1"])
def test_move_is_the_feedback_controllers_action_towards_the_target_before_it_is_clipped(
    motion: str,
) -> None:
    env = load(motion, error_observation=True, observation_noise=0.02, repeats=1)
    assert env.observation_spec()["move"].shape == (8,)
    largest = env.control_timestep() * env.task.max_joint_speed
    for timestep in [env.reset(), *at_rest_until_the_end(env)]:
        seen = timestep.observation
        error = joint_error(seen["joint_angles"], followed(seen, "target"))
        np.testing.assert_array_equal(seen["move"], error / largest)


def test_move_follows_feasible_angles_where_the_motion_has_them() -> None:
    fast = dataclasses.replace(ymca(), rate=50.0)
    with pytest.warns(RecordingWarning):
        env = load(fast, error_observation=True)
    seen = env.reset().observation
    way = wrap(seen["target_angles"] - seen["joint_angles"])
    np.testing.assert_allclose(seen["move"], way * fast.rate / env.task.max_joint_speed, atol=1e-12)


@pytest.mark.parametrize("options", [{}, {"observation_noise": 0.02, "lookahead": 2}], ids=str)
def test_move_of_each_of_many_is_that_of_a_single_environment(options: dict[str, Any]) -> None:
    singles = [load("ymca", seed=seed, error_observation=True, **options) for seed in range(3)]
    envs = make_vec(3, "ymca", error_observation=True, flat=True, **options)
    flat, _ = envs.reset()
    timesteps = [single.reset() for single in singles]
    for _ in range(10):
        for row, timestep in enumerate(timesteps):
            assert list(timestep.observation)[-1] == "move"
            np.testing.assert_array_equal(flat[row, -8:], timestep.observation["move"])
        actions = flat[:, -8:].clip(-1.0, 1.0)
        flat, *_ = envs.step(actions)
        timesteps = [one.step(own) for one, own in zip(singles, actions, strict=True)]
    envs.close()


def test_overwritten_observations_spoil_no_later_episode() -> None:
    env = load("ymca", phase=True, lookahead=2)
    first = {name: value.copy() for name, value in env.reset().observation.items()}
    env.task.episode = 0
    for value in env.reset().observation.values():
        value[:] = 7.0
    env.task.episode = 0
    for name, value in env.reset().observation.items():
        np.testing.assert_array_equal(value, first[name])


def test_observations_share_no_memory_with_any_option() -> None:
    options: dict[str, Any] = {"lookahead": 3, "phase": True, "error_observation": True}
    env = load("ymca", observation_noise=0.01, latency=1, **options)
    one, other = env.reset().observation, env.step(np.zeros(8)).observation
    kept = {name: value.copy() for name, value in one.items()}
    for value in other.values():
        value[:] = 7.0
    env.step(np.ones(8))
    for name, value in kept.items():
        np.testing.assert_array_equal(one[name], value)
        assert not any(np.shares_memory(one[name], later) for later in other.values())
    spec = env.observation_spec()
    assert one.keys() == spec.keys()
    for name, value in kept.items():
        spec[name].validate(value)
