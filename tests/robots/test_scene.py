"""The scene around a robot: that of two_arm.xml, as large as the robot needs."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from mpma_mj.kinematics import SIDES
from mpma_mj.robots.assembly import assemble
from mpma_mj.robots.geometry import chains
from mpma_mj.robots.poses import POSES, pose_angles
from mpma_mj.robots.robot import Robot
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.robots.scene import TWO_ARM_MODEL
from tests.robots.small_robot import compiled, placed, write_small_robot


@pytest.fixture
def small(tmp_path: Path) -> Robot:
    return read_robot(write_small_robot(tmp_path))


def test_the_scene_is_that_of_two_arm(small: Robot) -> None:
    model, ours = assemble(small).compile(), mujoco.MjModel.from_xml_path(str(TWO_ARM_MODEL))
    for name in ("timestep", "integrator", "gravity", "disableflags"):
        np.testing.assert_array_equal(getattr(model.opt, name), getattr(ours.opt, name))
    assert (model.vis.global_.offwidth, model.vis.global_.offheight) == (1920, 1088)
    for kind in ("camera", "light"):
        number = getattr(ours, {"camera": "ncam", "light": "nlight"}[kind])
        names = [getattr(model, kind)(index).name for index in range(number)]
        assert names == [getattr(ours, kind)(index).name for index in range(number)]
    skies = model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX
    assert skies.sum() == 1
    assert "ground" not in [model.geom(index).name for index in range(model.ngeom)]
    np.testing.assert_array_equal(model.geom("floor").friction, ours.geom("floor").friction)
    marks = model.site("left_wrist")
    assert (marks.group[0], marks.size[0]) == (4, 0.01)


@pytest.mark.parametrize("camera", ["front", "side", "three_quarter"])
@pytest.mark.parametrize("pose", POSES)
def test_cameras_see_the_arms(small: Robot, camera: str, pose: str) -> None:
    model = assemble(small).compile()
    data = placed(model, small, pose_angles(chains(model, small.joints), pose))
    mujoco.mj_camlight(model, data)
    seen = data.camera(camera)
    slope = np.tan(np.radians(model.camera(camera).fovy[0]) / 2.0)
    for side in SIDES:
        for part in (f"{side}_hand_link", f"{side[0]}_forearm", f"{side[0]}_link1"):
            x, y, z = (data.body(part).xpos - seen.xpos) @ seen.xmat.reshape(3, 3)
            assert abs(y / z) < slope
            assert abs(x / z) < slope * 4.0 / 3.0
            assert z < 0.0


def test_names_of_the_scene_are_free(tmp_path: Path) -> None:
    model = {'name="pedestal"': 'name="floor"'}
    found = compiled(read_robot(write_small_robot(tmp_path, model=model)))
    assert found.geom("floor").type[0] == mujoco.mjtGeom.mjGEOM_CYLINDER
    assert found.geom("floor_of_robot").type[0] == mujoco.mjtGeom.mjGEOM_BOX
