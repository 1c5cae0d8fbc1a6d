"""Robot files: what they may hold, and what is said of faults."""

import dataclasses
import os
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.errors import BadOptionError, MpmaError, RunFolderError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.robots.robot import QUANTITIES, UNKNOWN, JointValues
from mpma_mj.robots.robot_file import catalogue, read_robot, robot_name, write_robot
from mpma_mj.robots.scene import TWO_ARM_MODEL
from tests.robots.small_robot import installed, write_small_robot


def refused(robot: Any) -> str:
    with pytest.raises(BadOptionError) as caught:
        read_robot(robot)
    message = str(caught.value)
    assert "\n" not in message
    assert caught.value.exit_code == 2
    return message


def test_a_robot_file_says_all_of_a_robot(tmp_path: Path) -> None:
    path = write_small_robot(tmp_path)
    robot = read_robot(path)
    assert robot == read_robot(str(path))
    assert (robot.name, robot.title, robot.path) == ("small", "Small robot", path)
    assert robot.model == tmp_path / "small.xml"
    assert robot.joints[3:5] == ("l_elbow", "r_pitch")
    assert robot.wrists == ("l_wrist", "r_wrist")
    assert robot.up == (0.0, 0.0, 2.0)
    assert robot.rest == {"waist": 0.0}
    assert robot.values("speed").tolist() == [9.0, 8.0, 7.0, 6.0] * 2
    assert robot.physical["kv"].source == "choice"
    assert not robot.complete


TABLES = "[model.rest]\nwaist = 0.0\n[model.range]\nr_roll = [-1.5, 3.0]\n"


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("title", "titel", "has an unknown key titel; did you mean title?"),
        ("[speed]", "[speeds]", "has an unknown key speeds; did you mean speed?"),
        ("up =", "upp =", "has an unknown key model.upp; did you mean up?"),
        ("[kv]", "[kv]\nunit = 1", "has an unknown key kv.unit; expected one of values, source"),
        ('name = "small"', "", "name is missing; expected a text"),
        ('name = "small"', "name = 3", "name is 3; expected a text"),
        ('name = "small"', 'name = "a/b"', "name is 'a/b'; expected letters, digits, _ and -"),
        ('licence = "Apache-2.0, nobody"', 'licence = " "', "licence is ' '; expected a text"),
        ('file = "small.xml"', "", "model.file is missing; expected a text"),
        (
            'file = "small.xml"',
            'file = "no.xml"\npackage = "x"',
            "finds no model: pip install --no-deps x",
        ),
        ('file = "small.xml"', 'package = "x"\nmenagerie = "x"', "model.package is 'x'; leave it"),
        (', "l_elbow"]', "]", "model.left is ['l_pitch', 'l_roll', 'l_yaw']; expected four joints"),
        ('"r_elbow"', '"r_elbow", "r_wrist"', "expected four joints, from the shoulder outward"),
        ('"r_elbow"', '"r_elbow", "r_elbow"', "'r_elbow', 'r_elbow']; expected four joints"),
        (
            '"r_elbow"',
            '"r_yaw"',
            "model.right is ['r_pitch', 'r_roll', 'r_yaw', 'r_yaw']; expected",
        ),
        ('"r_elbow"', "4", "model.right is ['r_pitch', 'r_roll', 'r_yaw', 4]; expected"),
        ('left = ["l_pitch"', 'left = "l_pitch"\nlift = ["l_pitch"', "unknown key model.lift"),
        (
            'wrist = ["l_wrist", "r_wrist"]',
            "",
            'model.forearm is missing; expected forearm = "tip"',
        ),
        ("wrist = [", 'forearm = "tip"\nwrist = [', "model.forearm is 'tip'; expected"),
        ('wrist = ["l_wrist", "r_wrist"]', 'forearm = "end"', "model.forearm is 'end'; expected"),
        ('wrist = ["l_wrist", "r_wrist"]', 'wrist = ["l_wrist"]', "expected two joints"),
        ("up = [0, 0, 2]", "up = [0, 0, 0]", "model.up is [0, 0, 0]; expected a direction"),
        ("up = [0, 0, 2]", "up = [0, 0, nan]", "expected a list of 3 finite numbers"),
        ("up = [0, 0, 2]", "up = [0, 1]", "expected a list of 3 finite numbers"),
        ("up = [0, 0, 2]", 'up = "z"', "model.up is 'z'; expected a list"),
        ("up = [0, 0, 2]", "", "model.up is missing; expected a list"),
        ("waist = 0.0", 'waist = "0"', "model.rest is {'waist': '0'}; expected a table of joints"),
        ("waist = 0.0", "waist = inf", "model.rest is {'waist': inf}; expected"),
        ("[-1.5, 3.0]", "[3.0, -1.5]", "model.range.r_roll is [3.0, -1.5]; expected the lowest"),
        ("[-1.5, 3.0]", "2.0", "model.range.r_roll is 2.0; expected a list of 2 finite"),
        (TABLES, "range = 3\n", "model.range is 3; expected a table of joints"),
        ("[model.range]\nr_roll = [-1.5, 3.0]", "[speeds]", "has an unknown key speeds"),
        ("waist = 0.0\n[model.range]\n", "", "model.rest is {'r_roll': [-1.5, 3.0]}; expected"),
        ("[9, 8.0, 7.0, 6.0]", "[480, 8.0, 7.0, 6.0]", "at most 100 rad/s; are they degrees?"),
        ("[0.4, 0.3, 0.2, 0.0]", "[.4, 0.3, 0.2, 0.0]", "correct it, such as 0.05 for .05"),
        ("[9, 8.0, 7.0, 6.0]", "[9, 8.0, 7.0]", "speed.values is [9, 8.0, 7.0]; expected a list"),
        ("[9, 8.0, 7.0, 6.0]", "[9, 8.0, 7.0, 0.0]", "expected four numbers, above 0, rad/s"),
        ("[9, 8.0, 7.0, 6.0]", "[9, 8.0, 7.0, true]", "expected a list of 4 finite numbers"),
        ("[9, 8.0, 7.0, 6.0]", f"[9, 8.0, 7.0, 1{'0' * 400}]", "expected a list of 4 finite"),
        ("[0.4, 0.3, 0.2, 0.0]", "[0.4, 0.3, 0.2, -1]", "four numbers, 0 or more, N m s/rad"),
        ("values = [14.0, 13.0, 12.0, 11.0]", "", "kv.values is missing; expected a list of 4"),
        ('source = "choice"', "", "kv.source is missing; expected a text"),
        ('source = "choice"', 'source = "unknown"', "kv.source is 'unknown'; name the document"),
        ("[model]", "[[model]]\n[model]", "is no TOML file: Cannot declare ('model',) twice (at"),
        ("[speed]\n", "", "model.range.values is [9, 8.0, 7.0, 6.0]; expected a list of 2"),
        ('title = "', "title = ", "is no TOML file: Invalid value (at line 2, column 9)"),
    ],
)
def test_a_fault_is_named_with_its_key(tmp_path: Path, old: str, new: str, problem: str) -> None:
    path = write_small_robot(tmp_path, {old: new})
    message = refused(path)
    assert problem in message
    assert message.startswith(f"{path}: ")


def test_a_model_is_a_table(tmp_path: Path) -> None:
    path = tmp_path / "r.toml"
    for model in ("", 'model = "r.xml"', "model = []", "model = [1]"):
        path.write_text(f'name = "r"\ntitle = "R"\nlicence = "?"\n{model}')
        assert "expected a table [model], with file" in refused(path)


@pytest.mark.parametrize("kind", ["missing", "folder", "pipe", "latin", "deep"])
def test_a_robot_file_is_a_readable_file(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "r.toml"
    match kind:
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case "latin":
            path.write_bytes(b'name = "\xff"')
        case "deep":
            path.write_text(f"name = {'[' * 100_000}")
    expected = {"missing": "no such file", "folder": "is a folder", "pipe": "is a pipe"}
    assert expected.get(kind, "is no TOML file") in refused(path)


def test_a_name_that_is_unknown_is_answered_with_the_nearest() -> None:
    assert refused("cmu_humanoit").endswith("; did you mean cmu_humanoid?")
    assert "expected one of" in refused("nothing")
    assert refused("").startswith("robot is ''; expected one of")


@pytest.mark.parametrize("robot", [TWO_ARM_MODEL, str(TWO_ARM_MODEL), "two_arm"])
def test_a_model_with_our_joints_is_a_robot(robot: str | Path) -> None:
    found = read_robot(robot)
    assert found.complete
    assert found.joints == JOINT_NAMES
    assert found.model.samefile(TWO_ARM_MODEL)


def test_urdf_needs_a_robot_file(tmp_path: Path) -> None:
    assert "writes its robot file" in refused(tmp_path / "my.urdf")


@pytest.mark.parametrize("name", catalogue())
def test_the_catalogue_has_no_fault(name: str) -> None:
    robot = installed(name)  # a file is checked before its model is looked for
    assert robot.name == name
    assert robot.model.is_file()
    assert robot.complete or robot.physical["speed"].values is not None


@pytest.mark.parametrize("changes", [{}, {'wrist = ["l_wrist", "r_wrist"]': 'forearm = "tip"'}])
def test_what_is_written_is_read(tmp_path: Path, changes: dict[str, str]) -> None:
    unknown = {'values = [14.0, 13.0, 12.0, 11.0]\nsource = "choice"': 'source = "unknown"'}
    odd = {"Small robot": '\\"Ö\\" \\\\ \\u007f \\t 🤖'}
    robot = read_robot(write_small_robot(tmp_path, changes | unknown | odd))
    other = tmp_path / "other" / "r.toml"
    write_robot(other, robot)
    again = read_robot(other)
    assert again.model.samefile(robot.model)
    for key in ("name", "title", "licence", "joints", "up", "wrists", "rest", "ranges", "physical"):
        assert getattr(again, key) == getattr(robot, key)
    assert again.physical["kv"].source == UNKNOWN
    assert [path.name for path in other.parent.iterdir()] == ["r.toml"]


def test_a_complete_robot_is_five_lines(tmp_path: Path) -> None:
    path = tmp_path / "r.toml"
    write_robot(path, read_robot("two_arm"))
    assert len(path.read_text().split("\n")) == 7  # with an empty one, and the end
    assert read_robot(path).complete
    path.write_text(path.read_text() + "[speed]\n")
    assert "has an unknown key speed" in refused(path)


def test_a_file_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "r.toml").mkdir()
    with pytest.raises(RunFolderError, match="is a folder"):
        write_robot(tmp_path / "r.toml", read_robot("two_arm"))


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_an_unknown_value_is_refused_by_name(tmp_path: Path, quantity: str) -> None:
    robot = read_robot(write_small_robot(tmp_path))
    unknown = {name: value for name, value in robot.physical.items() if name != quantity}
    robot = dataclasses.replace(robot, physical=unknown)
    with pytest.raises(MpmaError, match=rf"small.toml: {quantity} of the joints, .* is unknown"):
        robot.values(quantity)
    assert robot.values(quantity, 2.0).tolist() == [2.0] * 8


def test_a_robot_says_which_of_its_physical_values_are_unknown() -> None:
    assert read_robot("cmu_humanoid").unknown == read_robot("two_arm").unknown == []
    robot = read_robot("cmu_humanoid")
    forceless = {name: one for name, one in robot.physical.items() if name != "force"}
    unsure = forceless | {"kv": JointValues()}
    assert dataclasses.replace(robot, physical=unsure).unknown == ["force", "kv"]


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("my robot.xml", "my_robot"),
        ("h1/robot.xml", "h1"),
        ("a b/model.urdf", "a_b"),
        ("/robot.xml", "robot"),
    ],
)
def test_a_robot_has_the_name_of_its_file_or_folder(path: str, name: str) -> None:
    assert robot_name(Path(path)) == name
