from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import mpma_mj
from mpma_mj import kinematics
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.kinematics import JOINT_NAMES

controls = arrays(np.float64, 8, elements=st.floats(-5.0, 5.0))


def settled(physics: PhysicsArms, angles: np.ndarray) -> PhysicsArms:
    with physics.reset_context():
        physics.data.qpos[:] = angles
    return physics


@given(controls)
def test_kinematic_arms_move_as_commanded(control: np.ndarray) -> None:
    physics = settled(KinematicArms.make(), np.full(8, 1.0))
    physics.set_control(control)
    physics.step(10)
    np.testing.assert_allclose(physics.joint_angles(), 1.0 + 0.05 * control, atol=1e-14)
    np.testing.assert_allclose(physics.joint_velocities(), control, atol=1e-12)
    np.testing.assert_allclose(
        physics.posture(), kinematics.posture_from_angles(physics.joint_angles()), atol=1e-12
    )
    assert physics.time() == pytest.approx(0.05)


def test_kinematic_arms_call_nothing_but_kinematics(monkeypatch: pytest.MonkeyPatch) -> None:
    physics = settled(KinematicArms.make(), np.full(8, 1.0))

    def forbidden(*_: object) -> None:
        raise AssertionError("dynamics were called")

    for name in ("mj_step", "mj_step1", "mj_step2", "mj_forward"):
        monkeypatch.setattr(mujoco, name, forbidden)
    physics.step(10)
    with physics.reset_context():
        pass


@pytest.mark.parametrize("kind", [PhysicsArms, KinematicArms])
def test_elbows_do_not_bend_backwards(kind: type[PhysicsArms]) -> None:
    physics = settled(kind.make(), np.array([0.0, 0, 0, 0.2] * 2))
    for _ in range(20):
        physics.set_control(np.array([0.0, 0, 0, -5.0] * 2))
        physics.step(10)
    assert (physics.joint_angles()[3::4] > -0.05).all()


def test_site_positions_are_up_to_date_after_a_step() -> None:
    physics = settled(PhysicsArms.make(), np.full(8, 0.5))
    physics.set_control(np.full(8, 2.0))
    physics.step(10)
    np.testing.assert_allclose(
        physics.posture(), kinematics.posture_from_angles(physics.joint_angles()), atol=1e-12
    )


def test_hanging_arms_rest() -> None:
    physics = settled(PhysicsArms.make(), np.zeros(8))
    physics.step(400)
    assert np.abs(physics.joint_angles()).max() < 0.01


def test_gravity_pulls_an_arm_down() -> None:
    physics = settled(PhysicsArms.make(), np.array([np.pi / 2, 0, 0, 0.1] * 2))
    physics.step(200)
    assert (physics.joint_angles()[::4] < np.pi / 2 - 0.05).all()


def test_torque_holds_a_horizontal_arm_as_statics_say() -> None:
    physics = settled(PhysicsArms.make(), np.array([np.pi / 2, 0, 0, 0.0] * 2))
    masses = (1.9783, 1.1826, 0.4453)
    levers = (0.1626, 0.2817 + 0.1230, 0.2817 + 0.2689 + 0.0681)
    torque = 9.81 * sum(m * r for m, r in zip(masses, levers, strict=True))
    assert physics.data.qfrc_bias[0] == pytest.approx(torque, rel=1e-3)


def test_an_arm_that_is_held_at_zero_sinks_as_fast_as_kv_and_damping_let_it() -> None:
    physics = settled(PhysicsArms.make(), np.array([np.pi / 2, 0, 0, 0.1] * 2))
    torque = physics.data.qfrc_bias[0]
    physics.step(10)
    # Servo of 20 and damping of 0.3 N m s/rad against gravity, once inertia has yielded.
    assert physics.joint_velocities()[0] == pytest.approx(-torque / 20.3, rel=0.15)


def test_kinematic_elbows_stop_at_both_ends_of_their_range() -> None:
    physics = settled(KinematicArms.make(), np.array([0.0, 0, 0, 2.6] * 2))
    physics.set_control(np.array([0.0, 0, 0, 15.0] * 2))
    physics.step(10)
    np.testing.assert_array_equal(physics.joint_angles()[3::4], 2.8)
    physics.set_control(np.array([0.0, 0, 0, -15.0] * 2))
    for _ in range(10):
        physics.step(10)
    np.testing.assert_array_equal(physics.joint_angles()[3::4], 0.0)


def test_both_arms_are_mirror_images_in_motion() -> None:
    physics = settled(PhysicsArms.make(), np.array([0.4, 0.3, 0.2, 0.6] * 2))
    rng = np.random.default_rng(0)
    for _ in range(40):
        physics.set_control(np.tile(rng.uniform(-3, 3, 4), 2))
        physics.step(10)
    left, right = physics.joint_angles().reshape(2, 4)
    np.testing.assert_allclose(left, right, atol=1e-9)


@given(arrays(np.float64, 8, elements=st.floats(-3.0, 3.0)))
def test_site_positions_of_a_posture_are_those_of_the_arms(angles: np.ndarray) -> None:
    physics = settled(KinematicArms.make(), angles)
    sites = physics.site_positions(physics.posture())
    for i, side in enumerate(kinematics.SIDES):
        for j, point in enumerate(("shoulder", "elbow", "wrist")):
            np.testing.assert_allclose(
                sites[i, j], physics.named.data.site_xpos[f"{side}_{point}"], atol=1e-12
            )


@pytest.mark.parametrize("steps", [0, 3])
@pytest.mark.parametrize("quantity", ["qvel", "qpos"])
def test_divergence_is_detected_in_any_step(steps: int, quantity: str) -> None:
    physics = PhysicsArms.make()
    physics.reset()
    for _ in range(steps):
        physics.step(10)
    assert physics.divergence == ""
    getattr(physics.data, quantity)[7] = 1e12
    physics.step(10)
    what = {"qvel": "velocity", "qpos": "angle"}[quantity]
    assert physics.divergence == f"the simulation diverged: the {what} of right_elbow ran away"
    np.testing.assert_array_equal(physics.joint_angles(), 0.0)
    np.testing.assert_array_equal(physics.joint_velocities(), 0.0)
    with physics.reset_context():
        pass
    assert physics.divergence == ""


def test_a_step_follows_from_the_state_alone() -> None:
    one, other = PhysicsArms.make(), PhysicsArms.make()
    settled(one, np.array([0.0, 0, 0, 0.1] * 2))
    for _ in range(5):  # drives elbows into their limits, where a solver is at work
        one.set_control(np.full(8, -5.0))
        one.step(10)
    settled(other, one.joint_angles())
    other.data.qvel[:] = one.joint_velocities()
    for physics in (one, other):
        physics.set_control(np.full(8, -5.0))
        physics.step(10)
    np.testing.assert_array_equal(one.joint_angles(), other.joint_angles())
    np.testing.assert_array_equal(one.joint_velocities(), other.joint_velocities())


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
