"""Nodes of a viser scene: poses by what the scene was given."""

import math
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

viser = pytest.importorskip("viser")

from mpma_mj.envs.options import EnvironmentOptions  # noqa: E402
from mpma_mj.envs.physics import PhysicsArms  # noqa: E402
from mpma_mj.visualization.viser_arms import (  # noqa: E402
    ArmNodes,
    ForceNode,
    GhostNodes,
    quaternion_from_z,
)
from tests.robots.small_robot import installed  # noqa: E402


@pytest.fixture(scope="module")
def server() -> Iterator["viser.ViserServer"]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def scene(server: "viser.ViserServer") -> "viser.SceneApi":
    server.scene.reset()
    return server.scene


def compiled(body: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")


@pytest.mark.parametrize("direction", [(0, 0, 2), (0, 0, -1), (3, 0, 0), (0.1, -0.7, -0.4)])
def test_quaternion_turns_the_z_axis_to_the_direction(direction: tuple[float, ...]) -> None:
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, np.array([0.0, 0.0, 1.0]), quaternion_from_z(np.array(direction)))
    np.testing.assert_allclose(turned, np.array(direction) / np.linalg.norm(direction), atol=1e-12)


@pytest.mark.parametrize("robot", ["cmu_humanoid", "h1"])
def test_a_robot_is_drawn_with_all_its_meshes(robot: str, scene: "viser.SceneApi") -> None:
    installed(robot)
    arms = PhysicsArms.make(EnvironmentOptions(robot=robot))
    model, data = arms.model.ptr, arms.data.ptr
    nodes = ArmNodes(scene, model, data)
    arms.set_joint_state(np.linspace(0.2, 0.9, 8), np.zeros(8))
    nodes.update(data)
    assert [*nodes.geoms] == np.flatnonzero(model.geom_group < 3).tolist()
    for joint in arms.kinematics.joint_names:
        body = data.body(int(model.joint(joint).bodyid[0]))
        frame = scene.get_handle_by_name(f"/arms/{body.name}")
        np.testing.assert_allclose(frame.position, body.xpos)
        np.testing.assert_allclose(frame.wxyz, body.xquat)
    for geom, node in nodes.geoms.items():
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            assert len(node.faces) == model.mesh_facenum[model.geom_dataid[geom]]


def test_arms_are_where_the_simulation_has_them(scene: "viser.SceneApi") -> None:
    arms = PhysicsArms.make()
    model, data = arms.model.ptr, arms.data.ptr
    nodes = ArmNodes(scene, model, data)
    arms.set_joint_state(np.linspace(0.2, 0.9, 8), np.zeros(8))
    nodes.update(data)
    for name in ("torso", "left_forearm", "right_hand"):
        frame = scene.get_handle_by_name(f"/arms/{name}")
        np.testing.assert_allclose(frame.position, data.body(name).xpos)
        np.testing.assert_allclose(frame.wxyz, data.body(name).xquat)
    assert [*nodes.geoms] == np.flatnonzero(model.geom_group < 3).tolist()
    palm = scene.get_handle_by_name("/arms/left_hand/left_palm")
    np.testing.assert_allclose(palm.position, model.geom("left_palm").pos)


def test_body_whose_name_has_a_slash_hangs_on_no_other_one(scene: "viser.SceneApi") -> None:
    inner = '<body name="arm/hand" pos="0 0 1"><joint/><geom size="0.1"/></body>'
    model = compiled(f'<body name="arm" pos="1 0 0"><joint/><geom size="0.1"/>{inner}</body>')
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ArmNodes(scene, model, data)
    hand = scene.get_handle_by_name("/arms/arm|hand")
    np.testing.assert_allclose(hand.position, [1.0, 0.0, 1.0])


def test_payload_that_comes_and_goes_is_seen(scene: "viser.SceneApi") -> None:
    arms = PhysicsArms.make(EnvironmentOptions(plants=[{}, {"payload": 2.0}]))
    nodes = ArmNodes(scene, arms.model.ptr, arms.data.ptr)
    ball = nodes.geoms[arms.model.ptr.geom("left_hand_payload").id]
    assert not ball.visible
    arms.set_plant(1)
    nodes.update(arms.data.ptr)
    assert ball.visible
    radius = (3 * 2.0 / (4 * math.pi * 7870.0)) ** (1 / 3)
    assert np.linalg.norm(ball.vertices, axis=1) == pytest.approx(radius, rel=1e-5)
    arms.set_plant(0)
    nodes.update(arms.data.ptr)
    assert not ball.visible


def test_ghosts_limbs_go_from_joint_to_joint(scene: "viser.SceneApi") -> None:
    arms = PhysicsArms.make()
    arms.set_joint_state(np.linspace(0.2, 0.9, 8), np.zeros(8))
    positions = arms.site_positions(arms.posture())
    GhostNodes(scene, arms.segment_lengths).update(positions)
    forearm = scene.get_handle_by_name("/ghost/1")
    np.testing.assert_allclose(forearm.position, positions[0, 1], atol=1e-9)
    end = np.zeros(3)
    mujoco.mju_rotVecQuat(end, np.array([0.0, 0.0, arms.segment_lengths[1]]), forearm.wxyz)
    np.testing.assert_allclose(forearm.position + end, positions[0, 2], atol=1e-6)


def test_arrow_is_as_long_as_the_force_and_hidden_without_one(scene: "viser.SceneApi") -> None:
    node = ForceNode(scene)
    arrow = scene.get_handle_by_name("/force")
    assert not arrow.visible
    node.update(np.array([0.1, 0.2, 0.3]), np.array([0.0, 100.0, 0.0]))
    assert arrow.visible
    np.testing.assert_allclose(arrow.points[0], [[0.1, 0.2, 0.3], [0.1, 0.7, 0.3]], atol=1e-6)
    node.update(np.zeros(3), np.zeros(3))
    assert not arrow.visible
