"""Points and chains of models."""

import mujoco
import numpy as np
import pytest

from mpma_mj.kinematics import JOINT_NAMES, posture_from_angles
from mpma_mj.robots.geometry import arm_points, chains, torso_axes
from mpma_mj.robots.scene import TWO_ARM_MODEL


@pytest.fixture
def two_arm() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(TWO_ARM_MODEL))


def test_chains_of_two_arm_are_its_closed_form(two_arm: mujoco.MjModel) -> None:
    angles = np.random.default_rng(3).uniform(-3.0, 3.0, (100, 8))
    arms = chains(two_arm, JOINT_NAMES)
    found = [arm.directions(angles[:, 4 * i : 4 * i + 4]) for i, arm in enumerate(arms)]
    np.testing.assert_allclose(np.hstack(found), posture_from_angles(angles), atol=1e-14)
    assert arms[0].lowest.tolist() == [-np.inf, -np.inf, -np.inf, 0.0]


def test_points_of_two_arm_are_its_sites_in_any_posture(two_arm: mujoco.MjModel) -> None:
    data = mujoco.MjData(two_arm)
    data.qpos[:] = np.random.default_rng(4).uniform(-2.0, 2.0, 8)
    mujoco.mj_kinematics(two_arm, data)
    shoulder, elbow, end = arm_points(two_arm, data, range(4), None)
    np.testing.assert_allclose(shoulder, data.site("left_shoulder").xpos, atol=1e-12)
    np.testing.assert_allclose(elbow, data.site("left_elbow").xpos, atol=1e-12)
    wrist = data.site("left_wrist").xpos
    along = (end - elbow) @ (wrist - elbow) / np.linalg.norm(end - elbow)
    assert along / np.linalg.norm(wrist - elbow) > np.cos(np.radians(5.0))


def test_axes_of_a_shoulder_that_do_not_meet_give_points_on_axes_3_and_4() -> None:
    """Axis 1 along x through 0; axis 2 along y through (0.1, 0, 0.2); axis 3 along z."""
    text = (
        "<mujoco><worldbody><body><joint axis='1 0 0'/><geom size='0.1'/><body>"
        "<joint axis='0 1 0' pos='0.1 0 0.2'/><geom size='0.1'/><body>"
        "<joint axis='0 0 1' pos='0.3 0.4 0'/><geom size='0.1'/><body pos='0 0 -0.5'>"
        "<joint axis='1 0 0' pos='0 0.6 0'/><geom size='0.1' pos='0 0 -0.7'/>"
        "</body></body></body></body></worldbody></mujoco>"
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    shoulder, elbow, end = arm_points(model, data, range(4), None)
    np.testing.assert_allclose(shoulder, [0.3, 0.4, 0.2], atol=1e-12)
    np.testing.assert_allclose(elbow, [0.3, 0.6, -0.5], atol=1e-12)
    np.testing.assert_allclose(end, [0.0, -0.04, -1.27], atol=0.05)


def test_up_is_kept_where_shoulders_are_not_level() -> None:
    points = np.zeros((2, 3, 3))
    points[0, 0], points[1, 0] = [0.0, 0.2, 1.1], [0.0, -0.2, 1.0]
    expected = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    np.testing.assert_allclose(torso_axes(points, (0.0, 0.0, 3.0)), expected, atol=1e-15)
