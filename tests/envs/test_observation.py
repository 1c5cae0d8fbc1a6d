"""Observations: noise, lookahead, phase."""

from typing import Any

import dm_env
import numpy as np
import pytest

from mpma_mj.envs.load import load


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
    env = load("ymca", lookahead=3, phase=True, observation_noise=0.01, latency=1)
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
