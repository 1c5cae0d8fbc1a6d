"""Physical values that models state: what is taken from them, and what is a comment only."""

from pathlib import Path

import mujoco
import pytest

from mpma_mj.robots.stated_values import stated_values
from tests.robots.figures import figure, names, urdf_figure

JOINTS = (*names("left"), *names("right"))


def of_mjcf(actuators: str, defaults: str = "") -> tuple[dict[str, object], dict[str, str]]:
    text = figure().replace("<worldbody>", f"<default>{defaults}</default><worldbody>")
    model = mujoco.MjModel.from_xml_string(
        text.replace("</mujoco>", f"<actuator>{actuators}</actuator></mujoco>")
    )
    values, comments = stated_values(Path("my.xml"), model, JOINTS)
    return {quantity: known.values for quantity, known in values.items()}, comments


def each(kind: str, attributes: str) -> str:
    return "".join(f'<{kind} joint="{joint}" {attributes}/>' for joint in JOINTS)


def test_limits_of_a_urdf_are_taken(tmp_path: Path) -> None:
    path = tmp_path / "my.urdf"
    text = urdf_figure()
    slow = text.index("<limit", text.index('name="right_roll"'))
    path.write_text(text[:slow] + text[slow:].replace('velocity="3"', 'velocity="2"', 1))
    values, comments = stated_values(path, mujoco.MjModel.from_xml_path(str(path)), JOINTS)
    assert values["speed"].values == (3.0, 2.0, 3.0, 3.0)  # that of the slower arm
    assert values["speed"].source == "my.urdf: velocity in <limit>; compare it with a data sheet"
    assert values["force"].values == (20.0,) * 4
    assert values["kv"].values == (20.0,) * 4
    assert comments == {}


def test_a_speed_that_no_joint_has_is_a_comment(tmp_path: Path) -> None:
    path = tmp_path / "my.urdf"
    path.write_text(urdf_figure().replace('velocity="3"', 'velocity="1000"'))
    values, comments = stated_values(path, mujoco.MjModel.from_xml_path(str(path)), JOINTS)
    assert "speed" not in values
    assert comments["speed"].startswith("my.urdf has 1000, 1000, 1000, 1000")


@pytest.mark.parametrize("limit", ['velocity="0" effort="0"', 'velocity="inf" effort="x"', ""])
def test_placeholders_of_a_urdf_are_not_taken(limit: str, tmp_path: Path) -> None:
    path = tmp_path / "my.urdf"
    path.write_text(urdf_figure(limit))
    model = mujoco.MjModel.from_xml_string(urdf_figure())
    assert stated_values(path, model, JOINTS) == ({}, {})


def test_speeds_of_velocity_actuators_are_taken() -> None:
    values, _ = of_mjcf(each("velocity", 'kv="4" ctrlrange="-6 6" ctrllimited="true" gear="2"'))
    assert values == {"speed": (3.0,) * 4}
    assert of_mjcf(each("velocity", 'kv="4"'))[0] == {}
    assert of_mjcf(each("position", 'kp="4" kv="1" ctrlrange="-6 6"'))[0] == {}


@pytest.mark.parametrize(
    ("actuators", "force"),
    [
        (each("motor", 'ctrlrange="-5 5" gear="4"'), "20, 20, 20, 20"),
        (each("position", 'kp="9" forcerange="-7 7"'), "7, 7, 7, 7"),
        (each("motor", 'forcerange="-5 5" ctrlrange="-1 1" gear="3"'), "15, 15, 15, 15"),
    ],
)
def test_forces_of_an_mjcf_are_comments(actuators: str, force: str) -> None:
    values, comments = of_mjcf(actuators, '<joint armature="1" damping="7"/>')
    assert values == {}
    assert comments == {
        "armature": "my.xml has 1, 1, 1, 1; often invented",
        "damping": "my.xml has 7, 7, 7, 7; often invented",
        "force": f"my.xml has {force}; often invented",
    }


def test_limits_of_joints_are_comments_too() -> None:
    _, comments = of_mjcf("", '<joint actuatorfrcrange="-30 30"/>')
    assert comments == {"force": "my.xml has 30, 30, 30, 30; often invented"}
