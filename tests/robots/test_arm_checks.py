"""Faults between a robot's file and its model, each said in one line that names the file."""

from pathlib import Path

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.assembly import assemble
from mpma_mj.robots.robot_file import read_robot
from tests.robots.small_robot import write_small_robot

WRISTS = 'wrist = ["l_wrist", "r_wrist"]'
LEFT = '"l_pitch", "l_roll", "l_yaw", "l_elbow"'
RIGHT = '"r_pitch", "r_roll", "r_yaw", "r_elbow"'


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('"l_yaw"', '"l_yow"', "left: small.xml has no joint l_yow; did you mean l_yaw?"),
        ('"r_yaw"', '"shoulder"', "right: small.xml has no joint shoulder; it has root, waist"),
        ('"l_wrist"', '"l_wrest"', "wrist: small.xml has no joint l_wrest; did you mean l_wrist?"),
        ("waist = ", "waste = ", "rest: small.xml has no joint waste; did you mean waist?"),
        ("waist = ", "root = ", "rest: joint root is neither a hinge nor a slide; leave it out"),
        ("waist = ", "l_yaw = ", "rest: joint l_yaw is one of an arm; leave it out"),
        ('"l_pitch"', '"root"', "left: joint root is not a hinge; arms can have hinges only"),
        ('"r_elbow"', '"l_elbow"', "joint l_elbow is in both arms; give each its own four"),
        ('"l_roll", "l_yaw"', '"l_yaw", "l_roll"', "left: joint l_roll does not hang on l_yaw"),
        ('"l_elbow"]', '"r_wrist"]', "left: joint r_wrist does not hang on l_yaw; give four"),
        (LEFT, '"l_clavicle", "l_pitch", "l_roll", "l_yaw"', "left: joint l_yaw does not hang on"),
        (LEFT, '"l_roll", "l_yaw", "l_elbow", "l_wrist"', "wrist: joint l_wrist does not hang on"),
        (WRISTS, 'wrist = ["r_wrist", "l_wrist"]', "wrist: joint r_wrist does not hang on l_elbow"),
        (WRISTS, 'wrist = ["l_elbow", "r_elbow"]', "wrist: joint l_elbow does not hang on l_elbow"),
        ("r_roll = ", "waist = ", "range: joint waist is of no arm; leave it out"),
        ("r_roll = ", "r_rol = ", "range: small.xml has no joint r_rol; did you mean r_roll?"),
        ("[-1.5, 3.0]", "[0.0, 0.05]", "the range of joint r_roll is 0 to 0.05 rad; are degrees"),
        ("up = [0, 0, 2]", "up = [1, 0, 0.1]", "up is [1.0, 0.0, 0.1], along the line of the"),
    ],
)
def test_a_fault_of_the_file_is_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    path = write_small_robot(tmp_path, {old: new})
    with pytest.raises(BadOptionError) as caught:
        assemble(read_robot(path))
    message = str(caught.value)
    assert message.startswith(f"{path}: {problem}")
    assert "\n" not in message


def test_exchanged_arms_are_noticed_by_their_names(tmp_path: Path) -> None:
    exchanged = {f"left = [{LEFT}]": f"left = [{RIGHT}]", f"right = [{RIGHT}]": f"right = [{LEFT}]"}
    path = write_small_robot(tmp_path, exchanged)
    with pytest.raises(BadOptionError, match="left names the joints of the right arm"):
        assemble(read_robot(path))


def test_a_shoulder_has_three_hinges(tmp_path: Path) -> None:
    skipped = {LEFT: '"l_pitch", "l_roll", "l_elbow", "l_wrist"', WRISTS: 'forearm = "tip"'}
    path = write_small_robot(tmp_path, skipped)
    with pytest.raises(BadOptionError) as caught:
        assemble(read_robot(path))
    expected = f"{path}: left: l_pitch, l_roll, l_elbow do not turn about one shoulder"
    assert str(caught.value).startswith(expected)


def test_a_model_that_is_missing_is_named_with_the_robot_file(tmp_path: Path) -> None:
    path = write_small_robot(tmp_path, {'file = "small.xml"': 'file = "gone.xml"'})
    with pytest.raises(BadOptionError) as caught:
        assemble(read_robot(path))
    assert str(caught.value).startswith(f"{path}: its model {tmp_path / 'gone.xml'}: no such file")


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('joint name="l_roll" axis="0 1 0"', 'joint name="l_roll" axis="0 0 1"', "parallel axes"),
        ('joint name="l_elbow" axis="1 0 0"', 'joint name="l_elbow" axis="0 0 1"', "cannot bend"),
        ('joint name="r_elbow" axis="1 0 0"', 'joint name="r_elbow" axis="nan 0 0"', "small"),
        ('name="r_forearm" pos="0 0 -0.3"', 'name="r_forearm"', "r_elbow is at the shoulder"),
        (
            '"r_clavicle" pos="-0.12 0',
            '"r_clavicle" pos="0.46 0',
            "both shoulders are at one point",
        ),
        ('name="l_forearm" pos="0 0 -0.3"', 'name="l_forearm" pos="0 0 -300"', "millimetres"),
        ('name="right_hand" pos="0 0 -0.25"', 'name="right_hand"', "the right forearm has no end"),
    ],
)
def test_arms_that_reach_nothing_are_refused(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    path = write_small_robot(tmp_path, model={old: new})
    with pytest.raises(BadOptionError, match=problem) as caught:
        assemble(read_robot(path))
    assert str(path.with_suffix("")) in str(caught.value)


def test_a_forearm_without_an_end_is_refused(tmp_path: Path) -> None:
    changes = {
        'type="capsule" size="0.03" fromto="0 0 0 0 0 -0.2"': 'size="0.001" mass="1"',
        'pos="0 0 -0.25" gravcomp="1"': 'pos="0 0 0"',
        '"0.02 0.02 0.05" pos="0 0 -0.05"': '"0.001 0.001 0.001" mass="1"',
    }
    path = write_small_robot(tmp_path, {WRISTS: 'forearm = "tip"'}, changes)
    with pytest.raises(BadOptionError, match="forearm has no end: nothing below it is away from"):
        assemble(read_robot(path))


@pytest.mark.parametrize("limits", ["-0.04 0.04", "-180 180"])
def test_mixed_up_units_of_ranges_are_noticed(tmp_path: Path, limits: str) -> None:
    model = {
        'name="l_yaw" axis="0 0 1" pos="0.01 0 0" range="-4 4"': f'name="l_yaw" range="{limits}"'
    }
    path = write_small_robot(tmp_path, model=model)
    with pytest.raises(BadOptionError, match=r"of joint l_yaw is .* are degrees and radians mixed"):
        assemble(read_robot(path))


def test_a_joint_without_range_turns_freely(tmp_path: Path) -> None:
    model = {'pos="0.01 0 0" range="-4 4"': 'pos="0.01 0 0" limited="false"'}
    compiled = assemble(read_robot(write_small_robot(tmp_path, model=model))).compile()
    assert not compiled.joint("l_yaw").limited
