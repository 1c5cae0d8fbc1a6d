"""Robots that are described by their model alone."""

from pathlib import Path
from typing import Any

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.assembly import assemble
from mpma_mj.robots.geometry import chains
from mpma_mj.robots.new_robot import describe_model
from mpma_mj.robots.robot_file import read_robot, write_robot
from mpma_mj.robots.scene import TWO_ARM_MODEL
from tests.robots.figures import figure, names, urdf_figure

LEFT, RIGHT = names("left"), names("right")


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "my.xml"
    path.write_text(figure())
    return path


def test_what_is_described_is_what_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "models" / "my.urdf"
    path.parent.mkdir()
    path.write_text(urdf_figure())
    new = describe_model(path, name="my")
    file = tmp_path / "my.toml"
    write_robot(file, new.robot, new.comments | {"damping": "not\nof one line"})
    read = read_robot(file)
    assert read.joints == new.robot.joints == (*LEFT, *RIGHT)
    assert read.wrists == ("left_wrist", "right_wrist")
    assert read.physical == dict(new.robot.physical) | {
        quantity: read.physical[quantity] for quantity in ("armature", "damping")
    }
    assert read.model.resolve() == path.resolve()
    assembled = assemble(read, ideal=True).compile()
    assert [arm.joints for arm in chains(assembled, read.joints)] == [tuple(LEFT), tuple(RIGHT)]


def test_a_model_with_the_joints_and_sites_of_two_arm_is_a_robot_already(tmp_path: Path) -> None:
    new = describe_model(TWO_ARM_MODEL, name="ours")
    assert new.robot.complete
    write_robot(tmp_path / "ours.toml", new.robot)
    assert len((tmp_path / "ours.toml").read_text().splitlines()) == 6
    assert read_robot(tmp_path / "ours.toml").complete


def test_joints_and_wrists_that_are_given_are_taken(model: Path) -> None:
    given = describe_model(model, name="my", left=LEFT, right=RIGHT, wrist=["tip"]).robot
    assert (given.joints, given.wrists) == ((*LEFT, *RIGHT), None)
    wrist = ("left_wrist0", "right_wrist0")
    assert describe_model(model, name="my", wrist=wrist).robot.wrists == wrist


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"left": LEFT[:3], "right": RIGHT}, "left has 3 joints (left_pitch, left_roll, left_yaw)"),
        ({"left": [*LEFT, "x"], "right": RIGHT}, "left has 5 joints"),
        ({"left": LEFT}, "right is missing; expected four joints, from the shoulder outward"),
        ({"left": RIGHT, "right": LEFT}, "left names the joints of the right arm"),
        ({"left": [*LEFT[:3], "left_elbo"], "right": RIGHT}, "did you mean left_elbow?"),
        ({"left": LEFT[::-1], "right": RIGHT[::-1]}, "does not hang on"),
        ({"wrist": ["left_wrist0"]}, "expected the joints at the ends of the left and the right"),
        ({"wrist": ["left_wrist0", "right_elbow"]}, "wrist: joint right_elbow does not hang on"),
        ({"up": (0.0, 1.0, 0.0)}, "up points along the line of the shoulders"),
    ],
)
def test_what_does_not_fit_the_model_is_refused(
    model: Path, options: dict[str, Any], problem: str
) -> None:
    with pytest.raises(BadOptionError) as caught:
        describe_model(model, name="my", **options)
    assert problem in str(caught.value)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (figure(arms=("left",)), "my.xml: has one arm only"),
        (figure(ranges=dict.fromkeys(("pitch", "roll", "yaw", "elbow"), "-.05 .04")),
         "my.xml: the range of joint left_pitch is -0.05 to 0.04 rad; are degrees and radians"),
        ("<mujoco", "my.xml: is no MJCF file"),
        ("<mujoco><worldbody><geom/></worldbody></mujoco>", "my.xml: Error: size 0 must be"),
    ],
)  # fmt: skip
def test_models_that_will_not_do_are_refused(tmp_path: Path, content: str, problem: str) -> None:
    path = tmp_path / "my.xml"
    path.write_text(content)
    with pytest.raises(BadOptionError) as caught:
        describe_model(path, name="my")
    message = str(caught.value)
    assert problem in message
    assert message.count("my.xml") == 1
    assert "\n" not in message
