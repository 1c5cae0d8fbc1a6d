"""Traces: what they say of the joint angles of any robot."""

import numpy as np
import pytest

from mpma_mj import load, make_agent
from mpma_mj.training.rollout import record_epoch
from tests.robots.humanoid import HUMANOID, short_dance, without_two_arm


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_true_joint_angles_are_those_of_the_robot(
    noise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = short_dance()
    without_two_arm(monkeypatch)
    env = load(motion, robot=HUMANOID, repeats=1, observation_noise=noise)
    trace = record_epoch(env, make_agent(env, kind="feedback_only"), 0)
    arms = env.task.kinematics
    true, observed = trace.true_joint_angles(arms), trace.joint_angles
    assert np.array_equal(true, observed) == (noise == 0.0)
    off, before = (np.abs(arms.posture(one) - trace.posture).mean() for one in (true, observed))
    assert off <= 0.1 * before + 1e-12
