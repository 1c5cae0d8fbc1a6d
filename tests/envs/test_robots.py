"""Environments of robots other than two_arm: the CMU humanoid of dm_control, always installed."""

import pickle
from typing import Any

import mujoco
import numpy as np
import pytest

import mpma_mj
from mpma_mj import load, make_vec, metrics
from mpma_mj.agents.config import MPMAConfig
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.load import arm_limits, prepare
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, RecordingWarning, StateError
from mpma_mj.motions import Motion, chain_fit, ymca
from mpma_mj.motions.feasible_motion import feasible
from mpma_mj.training.rollout import rollout
from tests.robots.small_robot import installed

pytestmark = pytest.mark.filterwarnings("ignore::mpma_mj.errors.RecordingWarning")

ROBOT = "cmu_humanoid"
JOINTS = tuple(f"{side}{joint}" for side in "lr" for joint in
               ("humerusrz", "humerusry", "humerusrx", "radiusrx"))  # fmt: skip


@pytest.fixture(scope="module")
def dance() -> Motion:
    """Return YMCA with the joint angles of the robot."""
    return prepare("ymca", EnvironmentOptions(robot=ROBOT))[0]


# Posture errors in percent: at least, that no controller can avoid; at most, of an agent.
@pytest.mark.parametrize("arms", ["physics", "kinematic"])
@pytest.mark.parametrize(
    ("robot", "least", "most"), [(ROBOT, 0.1, 0.5), ("h1", 0.01, 0.3), ("openarm", 0.1, 0.6)]
)
def test_an_agent_learns_to_dance_on_a_robot(
    robot: str, least: float, most: float, arms: Any
) -> None:
    installed(robot)
    envs = make_vec(1, "ymca", robot=robot, arms=arms, repeats=2)
    agent = mpma_mj.make_agent(envs, MPMAConfig(nodes=30), seed=[0])
    for number in range(3):
        trace = rollout(envs, agent, number)
        agent.learn()
    envs.close()
    motion = envs.motion
    shown = envs.arms.kinematics.posture(motion.joint_angles)
    unavoidable = metrics.posture_error_percent(shown, motion.posture)
    assert least < unavoidable < most
    danced = trace.of_run(0)
    assert danced is not None
    reached = metrics.posture_error_percent(danced.posture[1:], danced.reference[1:])
    assert reached < unavoidable + (0.05 if arms == "kinematic" else 0.3)


def test_joints_and_postures_are_the_robots(dance: Motion) -> None:
    env = load(dance, robot=ROBOT)
    assert tuple(env.action_spec().name.split("\t")) == JOINTS
    rng = np.random.default_rng(0)
    timestep = env.reset()
    for _ in range(20):
        seen = timestep.observation
        shown = env.task.kinematics.posture(seen["joint_angles"])
        np.testing.assert_allclose(seen["posture"], shown, atol=1e-9)
        timestep = env.step(rng.uniform(-1.0, 1.0, 8))
    velocity = env.physics.data.qvel[env.physics.dof_indices]
    np.testing.assert_array_equal(timestep.observation["joint_velocities"], velocity)


def test_demonstrated_angles_hold_the_demonstrated_posture(dance: Motion) -> None:
    env = load(dance, robot=ROBOT, reference_noise=0.0, lookahead=3, random_start=True)
    seen = env.reset().observation
    for name in ("reference", "target", "lookahead"):
        shown = env.task.kinematics.posture(seen[f"{name}_angles"])
        assert np.abs(shown - seen[name]).max() < 0.12  # what the robot cannot do
    np.testing.assert_allclose(seen["joint_angles"], seen["reference_angles"], atol=1e-9)


def test_many_robots_are_the_same_as_one(dance: Motion) -> None:
    options: dict[str, Any] = {
        "robot": ROBOT, "repeats": 1, "payload": (0.0, 1.0), "perturbation": (2.0, 20.0),
        "observation_noise": 0.01,
    }  # fmt: skip
    many = make_vec(2, dance, seed=3, **options)
    alone = [load(dance, seed=3 + row, **options) for row in range(2)]
    rng = np.random.default_rng(0)
    seen, _ = many.reset()
    each = [env.reset() for env in alone]
    for _ in range(30):
        action = rng.uniform(-0.5, 0.5, (2, 8))
        for row in range(2):
            for name, value in each[row].observation.items():
                np.testing.assert_array_equal(seen[name][row], value, name)
        seen, *_ = many.step(action)
        each = [env.step(action[row]) for row, env in enumerate(alone)]
    many.close()


def test_gymnasium_goes_on_after_pickling(dance: Motion) -> None:
    env = ImitationEnv(dance, robot=ROBOT, repeats=1)
    env.reset(seed=1)
    other = pickle.loads(pickle.dumps(env))
    action = np.full(8, 0.2)
    for _ in range(5):
        one, two = env.step(action), other.step(action)
        np.testing.assert_array_equal(one[0]["posture"], two[0]["posture"])


def test_options_act_on_a_robot(dance: Motion) -> None:
    plain = load(dance, robot=ROBOT)
    heavy = load(dance, robot=ROBOT, payload=1.5)
    mass = float(np.sum(heavy.physics.model.body_mass) - np.sum(plain.physics.model.body_mass))
    assert mass == pytest.approx(3.0)
    for side in ("left", "right"):
        wrist = heavy.physics.named.data.site_xpos[f"{side}_wrist"]
        ball = heavy.physics.named.data.xipos[f"{side}_hand_payload"]
        np.testing.assert_allclose(ball, wrist, atol=1e-9)
    floating = load(dance, robot=ROBOT, gravity_compensation=True).physics
    mujoco.mj_forward(floating.model.ptr, floating.data.ptr)
    bias = floating.data.qfrc_bias + -floating.data.qfrc_gravcomp
    np.testing.assert_allclose(bias[floating.dof_indices], 0.0, atol=1e-9)
    locked = load(dance, robot=ROBOT, locked_joint="lradiusrx")
    timestep = locked.reset()
    start = timestep.observation["joint_angles"][3]
    for _ in range(10):
        timestep = locked.step(np.full(8, 0.5))
    assert timestep.observation["joint_angles"][3] == pytest.approx(start, abs=1e-3)
    assert load(dance, robot=ROBOT, collisions=True).step(np.zeros(8)).observation is not None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"locked_joint": "left_elbow"},
            f"locked_joint is 'left_elbow'; expected one of {JOINTS[0]}",
        ),
        ({"robot": "cmu_humanoit"}, "did you mean cmu_humanoid?"),
        ({"robot": "gone.toml"}, "gone.toml: no such file"),
    ],
)
def test_what_a_robot_cannot_have_is_refused(
    dance: Motion, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(BadOptionError) as caught:
        load(dance, **({"robot": ROBOT} | options))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_joint_angles_of_one_robot_are_not_those_of_another(dance: Motion) -> None:
    own = load(dance).task.motion  # two_arm, within whose limits YMCA is
    assert own.feasible_angles is None
    assert own.angles_of == "two_arm"
    again = load(own, robot=ROBOT).task.motion
    np.testing.assert_array_equal(again.feasible_angles, dance.feasible_angles)


def test_a_demonstration_needs_the_joint_angles_of_the_robot(dance: Motion) -> None:
    limits, options = arm_limits(EnvironmentOptions(robot=ROBOT)), EnvironmentOptions(repeats=1)
    of_robot = limits.max_speed, limits.kinematics
    assert Demonstration(dance, options, *of_robot).has_angles
    with pytest.raises(StateError, match="ymca has no joint angles of cmu_humanoid"):
        Demonstration(ymca(), options, *of_robot)


def test_a_motion_is_fitted_once(dance: Motion, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(chain_fit, "fit_chain", fails)
    limits = arm_limits(EnvironmentOptions(robot=ROBOT))
    np.testing.assert_array_equal(feasible(ymca(), limits)[0].joint_angles, dance.joint_angles)
    assert feasible(dance, limits)[0] is dance


def test_what_a_robot_cannot_do_is_warned_of() -> None:
    with pytest.warns(RecordingWarning, match="cmu_humanoid has joints and speeds of its own"):
        load("ymca", robot=ROBOT)
