"""Arms of models: found whatever surrounds them, and refused by what is missing."""

import itertools
import os
from pathlib import Path

import dm_control
import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.robots.finder import describe_arms, find_arms
from mpma_mj.robots.model_file import read_model_file
from mpma_mj.robots.robot_file import catalogue
from mpma_mj.robots.scene import TWO_ARM_MODEL
from tests.robots.figures import ARM, compile_figure, figure, names
from tests.robots.small_robot import MODEL, installed

DM_CONTROL = Path(dm_control.__file__).parent
CMU = DM_CONTROL / "locomotion/walkers/assets/humanoid_CMU_V2020.xml"
CMU_ARM = ("humerusrz", "humerusry", "humerusrx", "radiusrx")
FORMS = (
    "{side}_{joint}",
    "{s}_{joint}",
    "{joint}_{side}",
    "robot/{s}{joint}",
    "wheeled_{s}_arm_{joint}",
)


def refused(model: mujoco.MjModel) -> str:
    with pytest.raises(BadOptionError) as caught:
        find_arms(model)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_arms_of_two_arm_are_found() -> None:
    found = find_arms(mujoco.MjModel.from_xml_path(str(TWO_ARM_MODEL)))
    assert (found.joints, found.wrists, found.up) == (JOINT_NAMES, None, (0.0, 0.0, 1.0))


def test_the_arms_of_the_humanoid_are_found_whose_y_is_up() -> None:
    found = find_arms(mujoco.MjModel.from_xml_path(str(CMU)))
    assert found.joints == tuple(side + joint for side in "lr" for joint in CMU_ARM)
    assert (found.wrists, found.up) == (("lhandrz", "rhandrz"), (0.0, 1.0, 0.0))
    assert found.guesses[0] == "y is up, from the middle of the trunk to the shoulders"


@pytest.mark.parametrize("name", catalogue())
def test_the_arms_of_the_catalogue_are_found(name: str) -> None:
    robot = installed(name)
    spec = read_model_file(robot.model)
    spec.compiler.fusestatic = False
    found = find_arms(spec.compile())
    assert found.joints == robot.joints
    np.testing.assert_allclose(found.up, robot.up)


def test_arms_that_begin_with_a_clavicle_are_found() -> None:
    found = find_arms(mujoco.MjModel.from_xml_string(MODEL))
    arm = ("pitch", "roll", "yaw", "elbow")
    assert found.joints == tuple(f"{s}_{joint}" for s in "lr" for joint in arm)
    assert found.wrists == ("l_wrist", "r_wrist")


@given(
    form=st.sampled_from(FORMS),
    arms=st.permutations(("left", "right")),
    order=st.sampled_from(list(itertools.permutations(("pitch", "roll", "yaw")))),
    lengths=st.tuples(st.floats(0.1, 0.5), st.floats(0.1, 0.5)),
    offset=st.sampled_from((0.0, 0.005, 0.02)),
    waist=st.integers(0, 3),
    wrist=st.lists(st.sampled_from(("0 0 1", "1 0 0", "0 1 0")), max_size=3),
    fingers=st.integers(0, 2),
    legs=st.booleans(),
)
def test_arms_are_found_among_all_other_hinges(
    form: str, arms: list[str], order: tuple[str, ...], **options: object
) -> None:
    arm = {joint: ARM[joint] for joint in (*order, "elbow")}
    model = compile_figure(form=form, arms=arms, arm=arm, **options)
    found = find_arms(model)
    expected = [names(side, form, list(arm)) for side in ("left", "right")]
    assert found.joints == tuple(itertools.chain(*expected))
    assert found.up == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("quaternion", "up"),
    [
        (".5 .5 .5 .5", (1.0, 0.0, 0.0)),
        (".5 -.5 -.5 -.5", (0.0, 1.0, 0.0)),
        (".7071068 .7071068 0 0", (0.0, -1.0, 0.0)),
        (".7071068 0 .7071068 0", (1.0, 0.0, 0.0)),
        (".7071068 0 -.7071068 0", (-1.0, 0.0, 0.0)),
    ],
)
def test_up_is_found_of_a_model_that_lies(quaternion: str, up: tuple[float, ...]) -> None:
    turned = np.empty(3)
    mujoco.mju_rotVecQuat(turned, np.array([0.0, 0.0, 1.0]), np.array(quaternion.split(), float))
    found = find_arms(compile_figure(frame=f'quat="{quaternion}"'))
    np.testing.assert_allclose(turned, up, atol=1e-6)
    assert found.up == up
    assert found.joints[0] == "left_pitch"


def test_up_that_is_given_is_taken() -> None:
    found = find_arms(compile_figure(), up=(0.0, 0.0, -1.0))
    assert found.up == (0.0, 0.0, -1.0)
    assert found.guesses == ("left and right by their names",)
    with pytest.raises(BadOptionError, match=r"^up points along the line of the shoulders"):
        find_arms(compile_figure(), up=(0.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("turn", "by"),
    [("0", "by their place, as if it looks along x"), ("1.5707963", "by what the arms reach")],
)
def test_sides_without_names_are_found_by_place_or_by_what_arms_reach(turn: str, by: str) -> None:
    people = {"pitch": "-3 .8", "yaw": "-.8 .8"}  # arms rise, and elbows bend, forward
    text = figure(frame=f'euler="0 0 {turn}"', arms=("right", "left"), ranges=people)
    text = text.replace("left", "one").replace("right", "two")
    found = find_arms(mujoco.MjModel.from_xml_string(text))
    assert found.joints[::4] == ("one_pitch", "two_pitch")
    assert found.guesses[1] == f"left and right {by}"


def test_arms_that_are_known_are_completed() -> None:
    model = compile_figure()
    joints = [model.joint(name).id for side in ("left", "right") for name in names(side)]
    found = describe_arms(model, joints)
    assert found.joints == (*names("left"), *names("right"))
    assert found.wrists == ("left_wrist0", "right_wrist0")


NO_YAW = {joint: axis for joint, axis in ARM.items() if joint != "yaw"}
TWICE = {"pitch": "0 1 0", "again": "0 1 0", "yaw": "0 0 1", "elbow": "0 1 0"}
ROLLS = {"pitch": "0 1 0", "roll": "1 0 0", "yaw": "0 1 0", "elbow": "0 0 1"}


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (
            {"arm": NO_YAW, "wrist": ()},
            "has limbs of 3 hinges (left_pitch, left_roll, left_elbow), 2 of them about the"
            " shoulder; an arm needs three there and one in the elbow",
        ),
        ({"arm": NO_YAW, "wrist": ("0 1 0",)}, "has limbs of 4 hinges (left_pitch, left_roll,"),
        (
            {"arm": NO_YAW, "fingers": 1},
            "(left_pitch, left_roll, left_elbow, left_wrist0), 2 of them about the shoulder",
        ),
        ({"arms": ("left",)}, "has one arm only (waist0, left_pitch, left_roll, left_yaw, left_"),
        ({"arms": ()}, "has no arms, but what is called legs, fingers or the like (left_hip"),
        ({"arms": (), "legs": False}, "has no two arms; an arm needs four hinges"),
        ({"arm": TWICE, "wrist": ()}, "left_pitch and left_again turn about parallel axes"),
        (
            {"arm": ROLLS, "wrist": ()},
            "(left_pitch, left_roll, left_yaw, left_elbow), 4 of them",
        ),
        ({"form": ""}, "is one of an arm; give it a name in the model"),
    ],
)
def test_models_without_such_arms_are_refused(options: dict[str, object], problem: str) -> None:
    assert problem in refused(compile_figure(**options))


def test_a_ball_joint_is_no_shoulder() -> None:
    arm = {"pitch": "0 1 0", "elbow": "0 1 0"}
    text = figure(arm=arm, wrist=(), waist=0)
    for side in ("left", "right"):
        hinge = f'<joint name="{side}_pitch" axis="0 1 0" range="-3 3"/>'
        assert hinge in text
        text = text.replace(hinge, f'<joint name="{side}_ball" type="ball"/>')
    message = refused(mujoco.MjModel.from_xml_string(text))
    assert "has limbs of 1 hinge (left_elbow), 1 of them about the shoulder; " in message
    assert "an arm needs three there and one in the elbow, and not a ball joint; " in message


def test_the_humanoid_of_two_hinges_a_shoulder_is_refused() -> None:
    model = mujoco.MjModel.from_xml_path(os.fspath(DM_CONTROL / "suite/humanoid.xml"))
    assert "(right_shoulder1, right_shoulder2, right_elbow), 2 of them about" in refused(model)
