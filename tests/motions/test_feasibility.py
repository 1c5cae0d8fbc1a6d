import dataclasses

import numpy as np

from mpma_mj.motions.feasibility import beyond_limits, joint_speeds
from tests.motions.known_motions import LIMITS, moving, raising


def test_speed_is_that_of_the_joint() -> None:
    np.testing.assert_allclose(joint_speeds(raising(4.0, joint=3))[:, 3], 4.0, rtol=1e-9)
    assert joint_speeds(raising(4.0, joint=3))[:, :3].max() < 1e-9


def test_rotation_of_a_straight_arm_is_held() -> None:
    angles = np.tile([0.3, 0.1, 0.0, 1e-4] * 2, (10, 1))
    angles[:, 2] = np.arange(10) * 1.5  # 30 rad/s
    assert joint_speeds(moving(angles)).max() < 0.01


def test_a_joint_that_is_too_fast_is_named_with_time_and_speed() -> None:
    motion = raising(5.0, frames=15)
    jump = motion.posture.copy()
    jump[6:] = raising(5.0 + 40.0 / 5, frames=15).posture[6:]
    motion = dataclasses.replace(motion, posture=jump, tempo=2.0, start=1.0)
    assert beyond_limits(motion, LIMITS).startswith(
        "left_shoulder_abduction would have to turn at 53.0 rad/s at 1.50 s, but its actuator"
        " reaches 12"
    )


def test_an_elbow_that_bends_too_far_is_named_with_time_and_angle() -> None:
    angles = np.tile([0.3, 0.1, 0.2, 0.5] * 2, (10, 1))
    angles[4, 7] = 2.9
    expected = "right_elbow would have to be at 2.90 rad at 0.20 s, but its range is 0 to 2.8"
    assert beyond_limits(moving(angles), LIMITS) == expected


def test_an_angle_that_cannot_be_seen_is_named() -> None:
    angles = np.tile([0.3, 0.1, 0.2, 0.5] * 2, (10, 1))
    angles[4, 3] = 0.01
    expected = "the angle of left_shoulder_rotation cannot be seen at 0.20 s"
    assert beyond_limits(moving(angles), LIMITS) == expected


def test_a_motion_within_the_limits_is_beyond_none() -> None:
    assert not beyond_limits(raising(5.0), LIMITS)
