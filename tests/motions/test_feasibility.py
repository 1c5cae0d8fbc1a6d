import dataclasses

import numpy as np
import pytest

from mpma_mj.errors import InfeasibleMotionError
from mpma_mj.motions.feasibility import check_feasibility, joint_speeds
from tests.motions.known_motions import SPEED, moving, raising


def test_speed_is_that_of_the_joint() -> None:
    np.testing.assert_allclose(joint_speeds(raising(4.0, joint=3))[:, 3], 4.0, rtol=1e-9)
    assert joint_speeds(raising(4.0, joint=3))[:, :3].max() < 1e-9


def test_rotation_of_a_straight_arm_is_not_counted() -> None:
    angles = np.tile([0.3, 0.1, 0.0, 1e-4] * 2, (10, 1))
    angles[:, 2] = np.arange(10) * 1.5  # 30 rad/s
    assert joint_speeds(moving(angles)).max() < 0.01


def test_what_is_too_fast_is_refused_with_joint_frame_and_speed() -> None:
    motion = raising(5.0, frames=15)
    jump = motion.posture.copy()
    jump[6:] = raising(5.0 + 40.0 / 5, frames=15).posture[6:]
    with pytest.raises(
        InfeasibleMotionError, match=r"left_shoulder_abduction .* at frame 6 of 15 .*tempo=0\.\d+"
    ):
        check_feasibility(dataclasses.replace(motion, posture=jump), SPEED, 2.8)


@pytest.mark.parametrize("tempo", [0.5, 1.0, 2.0])
def test_the_tempo_that_is_proposed_would_do(tempo: float) -> None:
    with pytest.raises(InfeasibleMotionError, match="left_shoulder_abduction") as caught:
        check_feasibility(dataclasses.replace(raising(20.0), tempo=tempo), SPEED, 2.8)
    proposed = float(str(caught.value).partition("tempo=")[2].split()[0])
    check_feasibility(raising(20.0 * proposed / tempo), SPEED, 2.8)


def test_an_elbow_that_bends_too_far_is_refused_by_name_and_frame() -> None:
    angles = np.tile([0.3, 0.1, 0.2, 0.5] * 2, (10, 1))
    angles[4, 7] = 2.9
    with pytest.raises(
        InfeasibleMotionError, match=r"right_elbow .* by 2\.90 rad at frame 5 of 10"
    ):
        check_feasibility(moving(angles), SPEED * 10, 2.8)
