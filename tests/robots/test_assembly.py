"""Models of robots: what is kept, what is removed, and that nothing moves but by one turn."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import SIDES
from mpma_mj.robots.assembly import HANDS, assemble
from mpma_mj.robots.geometry import POINTS, chains
from mpma_mj.robots.poses import POSES, pose_angles
from mpma_mj.robots.robot import Robot
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.robots.scene import TWO_ARM_MODEL
from tests.robots.small_robot import (
    compiled,
    compiled_once,
    installed,
    placed,
    write_small_robot,
)

Array = NDArray[np.float64]

ROBOTS = ["cmu_humanoid", "h1", "openarm", "g1", "gr1", "yumi"]
BEYOND = {("g1", "arms up"), ("gr1", "arms up")}  # their shoulders stop 8 to 10 degrees before
REST = {"waist = 0.0": "waist = 0.5\nl_wrist = 0.3\nl_clavicle = -0.4"}


@pytest.fixture
def small(tmp_path: Path) -> Robot:
    return read_robot(write_small_robot(tmp_path, REST))


def shown(data: mujoco.MjData) -> Array:
    """Return the directions between the sites, shape (2, 6)."""
    found = []
    for side in SIDES:
        points = np.array([data.site(f"{side}_{point}").xpos for point in POINTS])
        segments = np.diff(points, axis=0)
        found.append((segments / np.linalg.norm(segments, axis=1, keepdims=True)).ravel())
    return np.array(found)


@pytest.mark.parametrize("name", ["small", *ROBOTS])
def test_sites_point_where_the_chains_do(name: str, tmp_path: Path) -> None:
    robot = read_robot(write_small_robot(tmp_path, REST)) if name == "small" else installed(name)
    model = compiled(robot) if name == "small" else compiled_once(name)
    arms = chains(model, robot.joints)
    for angles in np.random.default_rng(5).uniform(-3.0, 3.0, (50, 8)):
        expected = [
            arm.directions(four) for arm, four in zip(arms, angles.reshape(2, 4), strict=True)
        ]
        np.testing.assert_allclose(shown(placed(model, robot, angles)), expected, atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("pose", POSES)
def test_plain_poses_are_right_to_5_degrees(name: str, pose: str) -> None:
    robot, model = installed(name), compiled_once(name)
    angles = pose_angles(chains(model, robot.joints), pose)
    x, y, z = POSES[pose]
    goal = np.array([[x, y, z] * 2, [x, -y, z] * 2])
    cosines = np.vecdot(shown(placed(model, robot, angles)).reshape(4, 3), goal.reshape(4, 3))
    worst = float(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))).max())
    assert worst < (15.0 if (name, pose) in BEYOND else 5.0)


def test_all_bodies_are_where_the_model_has_them_but_for_one_turn(small: Robot) -> None:
    model = assemble(small).compile()
    bare = mujoco.MjModel.from_xml_path(str(small.model))
    angles = np.random.default_rng(1).uniform(-1.0, 1.0, 8)
    before, after = mujoco.MjData(bare), placed(model, small, angles)
    rest = {"waist": 0.5, "l_wrist": 0.3, "l_clavicle": -0.4}
    for name, angle in (*rest.items(), *zip(small.joints, angles, strict=True)):
        before.qpos[bare.joint(name).qposadr] = angle
    mujoco.mj_kinematics(bare, before)
    turn = after.body("torso").xmat.reshape(3, 3) @ before.body("torso").xmat.reshape(3, 3).T
    shift = after.body("torso").xpos - turn @ before.body("torso").xpos
    assert np.linalg.det(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(turn[2], [0.0, 0.0, 1.0], atol=1e-12)  # up stays up here
    for index in range(bare.nbody - 1):
        name = bare.body(index + 1).name
        name = f"{name}_link" if name in HANDS else name
        then, now = before.xpos[index + 1], after.body(name).xpos
        np.testing.assert_allclose(now, turn @ then + shift, atol=1e-12)
        own = before.xmat[index + 1].reshape(3, 3)
        np.testing.assert_allclose(after.body(name).xmat.reshape(3, 3), turn @ own, atol=1e-12)
    pedestal = before.geom("pedestal").xpos
    np.testing.assert_allclose(after.geom("pedestal").xpos, turn @ pedestal + shift, atol=1e-12)


def test_the_torso_is_upright_looks_ahead_and_stands_on_the_floor(small: Robot) -> None:
    model = assemble(small).compile()
    data = placed(model, small, np.zeros(8))
    left, right = (data.site(f"{side}_shoulder").xpos for side in SIDES)
    np.testing.assert_allclose(left[:2] + right[:2], 0.0, atol=1e-12)
    assert left[1] > 0.1
    assert abs(left[0]) < 1e-12
    pedestal = data.geom("pedestal").xpos[2] - 0.02
    hanging = left[2] - np.linalg.norm(left - data.site("left_elbow").xpos) - 0.35 - 0.03
    assert min(pedestal, hanging) == pytest.approx(0.0, abs=0.06)
    assert pedestal >= -1e-9


def test_a_rest_angle_and_a_joint_s_own_zero_need_no_remedy(tmp_path: Path) -> None:
    plain = assemble(read_robot(write_small_robot(tmp_path))).compile()
    assert plain.njnt == 8
    assert not plain.qpos0.any()
    assert plain.joint("l_elbow").range.tolist() == [-0.5, 2.5]
    assert plain.joint("r_roll").range.tolist() == [-1.5, 3.0]


def test_degrees_stay_degrees(tmp_path: Path) -> None:
    model = {'angle="radian"': 'angle="degree"', 'range="-4 4"': 'range="-180 180"'}
    model |= {"-0.5 2.5": "-30 150", 'ref="0.2"': 'ref="10"'}
    compiled = assemble(read_robot(write_small_robot(tmp_path, model=model))).compile()
    assert compiled.joint("l_elbow").range == pytest.approx(np.radians([-30.0, 150.0]))
    assert compiled.joint("r_roll").range == pytest.approx([-1.5, 3.0])  # the file's, rad


def test_only_the_file_acts_on_the_joints(small: Robot) -> None:
    model = assemble(small).compile()
    assert [model.joint(index).name for index in range(8)] == list(small.joints)
    assert [model.actuator(index).name for index in range(model.nu)] == list(small.joints)
    assert model.actuator_ctrlrange[:, 1].tolist() == [9.0, 8.0, 7.0, 6.0] * 2
    assert model.actuator_forcerange[:, 0].tolist() == [-40.0, -30.0, -20.0, -10.0] * 2
    assert model.actuator_gainprm[:, 0].tolist() == [14.0, 13.0, 12.0, 11.0] * 2
    np.testing.assert_array_equal(model.actuator_biasprm[:, 2], -model.actuator_gainprm[:, 0])
    assert (model.actuator_gear[:, 0] == 1.0).all()
    assert model.dof_armature.tolist() == [0.04, 0.03, 0.02, 0.0] * 2
    assert model.dof_damping.tolist() == [0.4, 0.3, 0.2, 0.0] * 2
    for nothing in (model.dof_frictionloss, model.jnt_stiffness, model.jnt_actfrclimited):
        assert not nothing.any()
    assert not model.body_gravcomp.any()
    assert (model.nsensor, model.neq, model.nkey, model.ntendon) == (0, 0, 0, 0)


def test_the_hands_are_bodies_at_the_wrists(small: Robot) -> None:
    model = assemble(small).compile()
    data = placed(model, small, np.full(8, 0.3))
    mujoco.mj_comPos(model, data)
    for side, hand in zip(SIDES, HANDS, strict=True):
        np.testing.assert_array_equal(data.body(hand).xpos, data.site(f"{side}_wrist").xpos)
        np.testing.assert_array_equal(data.body(hand).xipos, data.body(hand).xpos)
    names = [model.body(index).name for index in range(model.nbody)]
    excluded = [(pair >> 16, pair & 0xFFFF) for pair in model.exclude_signature.tolist()]
    own = {names.index("left_hand_link"), names.index("torso")}
    assert own in [set(pair) for pair in excluded]
    assert all(names)


def test_unknown_values_are_refused_where_physics_needs_them(tmp_path: Path) -> None:
    unknown = {'values = [40.0, 30.0, 20.0, 10.0]\nsource = "data sheet"': 'source = "unknown"'}
    robot = read_robot(write_small_robot(tmp_path, unknown))
    with pytest.raises(
        BadOptionError, match=r"small.toml: force of the joints, N m, is unknown; .* arms=kinematic"
    ):
        assemble(robot)
    assert assemble(robot, ideal=True).compile().nu == 8
    slow = {'values = [9, 8.0, 7.0, 6.0]\nsource = "data sheet"': 'source = "unknown"'}
    for ideal in (True, False):
        with pytest.raises(BadOptionError, match="speed of the joints, rad/s, is unknown"):
            assemble(read_robot(write_small_robot(tmp_path, slow)), ideal=ideal)


def test_a_complete_robot_is_taken_as_it_is() -> None:
    ours = mujoco.MjSpec.from_file(str(TWO_ARM_MODEL))
    assert assemble(read_robot("two_arm")).to_xml() == ours.to_xml()


def test_a_model_that_cannot_be_read_is_refused_in_one_line(tmp_path: Path) -> None:
    for model in ({"<worldbody>": "<worldbodi>"}, {'type="sphere" size="0.04"': 'type="mesh"'}):
        robot = read_robot(write_small_robot(tmp_path, model=model))
        with pytest.raises(BadOptionError) as caught:
            assemble(robot)
        assert str(caught.value).startswith(f"{robot.model}: ")
        assert "\n" not in str(caught.value)


def test_what_collides_is_not_drawn_beside_meshes_for_looks(tmp_path: Path) -> None:
    mesh = '<geom name="{}" type="mesh" mesh="cube" pos="0 0 {}" contype="{}" conaffinity="{}"/>'
    meshes = (
        mesh.format("drawn", 0, 0, 0) + mesh.format("same", 0, 1, 1) + mesh.format("b", 1, 1, 1)
    )
    asset = '<asset><mesh name="cube" builtin="sphere" params="2"/>'
    text = {"<asset>": asset, '<joint name="waist"': f'{meshes}<joint name="waist"'}
    found = compiled(read_robot(write_small_robot(tmp_path, model=text)))
    assert [found.geom(name).group[0] for name in ("drawn", "same", "b")] == [0, 3, 3]
    del text["<asset>"]
    text['<joint name="waist"'] = '<geom name="b" size="0.1"/><joint name="waist"'
    alone = compiled(read_robot(write_small_robot(tmp_path, model=text)))
    assert alone.geom("b").group[0] == 0


def test_the_same_robot_is_the_same_model(small: Robot) -> None:
    assert assemble(small).to_xml() == assemble(small).to_xml()


def test_a_urdf_model_is_assembled(tmp_path: Path) -> None:
    links, joints = ['<link name="base">{}</link>'], []
    for side, sign in (("l", 1), ("r", -1)):
        parent = "base"
        for name, axis, place in (
            ("pitch", "0 1 0", f"0 {0.2 * sign} 0.4"),
            ("roll", "1 0 0", "0 0 0"),
            ("yaw", "0 0 1", "0 0 0"),
            ("elbow", "0 1 0", "0 0 -0.3"),
        ):
            link = f"{side}_{name}_link"
            links.append(f'<link name="{link}">{{}}</link>')
            joints.append(
                f'<joint name="{side}_{name}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{link}"/><origin xyz="{place}"/><axis xyz="{axis}"/>'
                '<limit lower="-2.5" upper="2.5" effort="1" velocity="1"/></joint>'
            )
            parent = link
    body = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        '</inertial><collision><origin xyz="0 0 -0.1"/><geometry><box size="0.05 0.05 0.2"/>'
        "</geometry></collision>"
    )
    text = "".join([*links, *joints]).format(*[body] * len(links))
    (tmp_path / "small.urdf").write_text(f'<robot name="u">{text}</robot>')
    changes = {'"small.xml"': '"small.urdf"', 'wrist = ["l_wrist", "r_wrist"]': 'forearm = "tip"'}
    robot = read_robot(write_small_robot(tmp_path, changes | {"waist = 0.0": ""}))
    model = assemble(robot).compile()
    directions = shown(placed(model, robot, np.zeros(8)))
    np.testing.assert_allclose(directions, [[0.0, 0.0, -1.0] * 2] * 2, atol=0.02)
