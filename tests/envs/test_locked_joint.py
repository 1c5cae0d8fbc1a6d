"""A joint that does not turn."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import mpma_mj
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.kinematics import JOINT_NAMES


@pytest.mark.parametrize("joint", JOINT_NAMES)
def test_a_locked_joint_holds_under_load_and_the_others_do_not(joint: str) -> None:
    arms = PhysicsArms.make(EnvironmentOptions(locked_joint=joint))
    number = JOINT_NAMES.index(joint)
    arms.set_joint_state(np.tile([0.5, 0.2, 0.1, 1.0], 2), np.zeros(8))
    before = arms.joint_angles()
    pull = np.zeros(8)
    pull[number] = 70.0  # N m
    arms.data.ptr.qfrc_applied[arms.dof_indices] = pull
    arms.set_control(np.where(pull, 10.0, 0.0))
    arms.step(2000)  # 10 s
    moved = np.abs(arms.joint_angles() - before)
    assert moved[number] < 0.01
    assert np.delete(moved, number).max() > 0.1  # they sink
    assert arms.divergence == ""


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
@pytest.mark.parametrize("random_start", [False, True])
def test_a_locked_joint_stays_where_the_episode_begins(arms: Any, random_start: bool) -> None:
    options = {"arms": arms, "random_start": random_start, "repeats": 9}
    env = mpma_mj.load("ymca", locked_joint="right_elbow", **options)
    free = mpma_mj.load("ymca", **options)
    start = env.reset().observation
    np.testing.assert_array_equal(start["joint_angles"], free.reset().observation["joint_angles"])
    assert start["joint_velocities"][7] == 0.0
    rng = np.random.default_rng(0)
    for _ in range(40):
        action = rng.uniform(-1, 1, 8)
        timestep = env.step(action)
        seen, unlocked = timestep.observation, free.step(action).observation
    assert not timestep.last()
    off = np.abs(seen["joint_angles"] - start["joint_angles"])
    assert off[7] < 1e-6
    assert off[:7].max() > 0.1
    assert abs(unlocked["joint_angles"][7] - start["joint_angles"][7]) > 0.01
    if arms == "kinematic":
        assert off[7] == 0.0
        np.testing.assert_array_equal(seen["joint_angles"][:7], unlocked["joint_angles"][:7])


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_a_locked_joint_is_the_same_through_every_interface(arms: Any) -> None:
    options = {"arms": arms, "locked_joint": "left_shoulder_abduction"}
    env, envs = mpma_mj.load("ymca", **options), mpma_mj.make_vec(2, "ymca", **options)
    gym = gymnasium.make("mpma_mj:TwoArmImitation-v0", motion="ymca", **options)
    env.reset(), envs.reset(), gym.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(20):
        action = rng.uniform(-1, 1, 8)
        one = env.step(action).observation
        many = envs.step(np.tile(action, (2, 1)))[0]
        behind_gym = gym.step(action)[0]
        for name, expected in one.items():
            np.testing.assert_array_equal(many[name][0], expected)
            np.testing.assert_array_equal(behind_gym[name], expected)
    envs.close(), gym.close()
