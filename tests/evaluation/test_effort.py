"""Torque and work: that momentum and energy are what they have to be."""

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.envs.load import load
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.evaluation.effort import actuator_torque, effort
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.training.factory import make_agent
from mpma_mj.training.rollout import record_epoch

Array = NDArray[np.float64]
DAMPING = 0.3  # N m s/rad, of each joint of two_arm.xml


def danced(**condition: object) -> Trace:
    env = load("ymca", repeats=1, **condition)
    return record_epoch(env, make_agent(env, kind="feedback_only"), 0)


@pytest.mark.parametrize(
    "condition",
    [{}, {"actuator_strength": 0.1}, {"actuator_gain": 0.6}],
    ids=["as they are", "weak", "low gain"],
)
def test_torques_are_what_changes_the_arms_momentum(condition: dict[str, float]) -> None:
    trace = danced(**condition)
    options = EnvironmentOptions(**condition)  # type: ignore[arg-type]
    cost = effort(trace, options, ymca().rate)
    assert cost is not None
    arms = PhysicsArms.make(options)
    model, data = arms.model.ptr, arms.data.ptr
    arms.set_joint_state(trace.joint_angles[0], trace.joint_velocities[0])
    inertia = np.zeros((8, 8))
    for step, torque in enumerate(cost.torque):
        arms.set_control(np.clip(trace.action[step // 10], -1, 1) * arms.max_joint_speed)
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, inertia)
        before, bias = data.qvel.copy(), data.qfrc_bias.copy()
        mujoco.mj_step(model, data)
        change = inertia @ (data.qvel - before) / cost.timestep
        np.testing.assert_allclose(change + bias + DAMPING * data.qvel, torque, atol=1e-9)
    np.testing.assert_array_equal(data.qpos, trace.joint_angles[-1])


def test_work_less_losses_is_the_energy_that_the_arms_have_gained() -> None:
    trace = danced()
    cost = effort(trace, EnvironmentOptions(), ymca().rate)
    assert cost is not None
    arms = PhysicsArms.make()
    model, data = arms.model.ptr, arms.data.ptr
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    energies = []
    for moment in (0, -1):
        arms.set_joint_state(trace.joint_angles[moment], trace.joint_velocities[moment])
        mujoco.mj_forward(model, data)
        energies.append(float(data.energy.sum()))
    put_in = float(cost.power.sum()) * cost.timestep
    lost = DAMPING * float((cost.velocity**2).sum()) * cost.timestep
    # The integrator is of the first order: what it loses of its own is small beside the work.
    assert put_in - lost == pytest.approx(energies[1] - energies[0], abs=0.05 * cost.work)
    assert cost.work > 50.0


def test_carried_arms_at_rest_cost_nothing_and_ideal_ones_have_no_effort() -> None:
    still = Trace(
        posture=np.zeros((21, 12)),
        reference=np.zeros((21, 12)),
        context=np.ones((21, 1)),
        joint_angles=np.tile([0.5, 0.3, 0.2, 1.0], (21, 2)),
        joint_velocities=np.zeros((21, 8)),
        action=np.zeros((20, 8)),
        reward=np.zeros(20),
    )
    carried = effort(still, EnvironmentOptions(gravity_compensation=True), 20.0)
    assert carried is not None
    assert carried.peak_torque < 1e-9
    assert carried.work < 1e-12
    heavy = effort(still, EnvironmentOptions(), 20.0)
    assert heavy is not None
    assert heavy.mean_torque > 1.0
    assert effort(still, EnvironmentOptions(arms="kinematic"), 20.0) is None


def test_a_torque_is_at_its_limit_where_the_command_is_beyond_it() -> None:
    velocity = np.array([[0.0] * 8, [0.5] * 8])
    control = np.full((1, 8), 2.0)
    free = actuator_torque(control, velocity, np.full(8, 20.0), np.full(8, 70.0))
    np.testing.assert_allclose(free, 20.0 * (2.0 - 0.5))
    held = actuator_torque(control, velocity, np.full(8, 20.0), np.full(8, 25.0))
    np.testing.assert_allclose(held, 25.0)
    held = actuator_torque(-control, velocity, np.full(8, 20.0), np.full(8, 25.0))
    np.testing.assert_allclose(held, -25.0)


def test_a_locked_joint_is_not_driven() -> None:
    condition = {"locked_joint": "left_elbow"}
    cost = effort(danced(**condition), EnvironmentOptions(**condition), ymca().rate)
    assert cost is not None
    assert np.abs(cost.torque[:, 3]).max() < 0.01 * np.abs(cost.torque).max()
