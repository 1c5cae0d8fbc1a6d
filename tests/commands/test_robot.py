"""`mpma robot`: the robot file, the picture, the report, and what is refused."""

import subprocess
import sys
from pathlib import Path

import imageio.v2 as imageio
import pytest

from mpma_mj.cli import main
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.robots.scene import TWO_ARM_MODEL
from tests.conftest import Refused
from tests.robots.figures import figure, names, urdf_figure

LEFT, RIGHT = names("left"), names("right")


@pytest.fixture(autouse=True)
def _in_a_folder_with_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my.xml").write_text(figure())
    Path("my.urdf").write_text(urdf_figure())


def test_a_urdf_becomes_a_robot_that_can_dance_ideally(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "my.urdf", "--no-picture"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "my: my.urdf"
    assert "guessed   z is up, against gravity; left and right by their names" in lines
    assert f"left      {', '.join(LEFT)}" in lines
    assert "poses     T-pose        0.0° off" in lines
    assert any(line.startswith("reachable 100 % of the postures of ymca") for line in lines)
    assert "damping   unknown" in lines
    assert lines[-2:] == [
        "file      my.toml",
        "next: mpma imitate ymca --robot my.toml --arms kinematic",
    ]
    robot = read_robot("my.toml")
    assert robot.joints == (*LEFT, *RIGHT)
    assert robot.values("speed").tolist() == [3.0] * 8
    assert not Path("my-poses.png").exists()


def test_meshes_that_are_left_out_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    mesh = '<geometry><mesh filename="forearm.dae"/></geometry>'
    Path("my.urdf").write_text(urdf_figure(visible=mesh))
    assert main(["robot", "my.urdf", "--no-picture"]) == 0
    assert "meshes    1 left out, as MuJoCo does not read .dae; " in capsys.readouterr().out


@pytest.mark.usefixtures("opengl")
def test_the_picture_is_next_to_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robot", "my.xml", "--out", "robots/dancer.toml", "--name", "dancer"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-3] == "picture   robots/dancer-poses.png"
    assert lines[-1].startswith("next: write the joints' top speeds and their source into robots/")
    assert imageio.imread("robots/dancer-poses.png").shape[1] > 1000
    assert read_robot("robots/dancer.toml").name == "dancer"
    Path("robots/dancer-poses.png").unlink()
    assert main(["robot", "robots/dancer.toml"]) == 0
    assert Path("robots/dancer-poses.png").exists()


def test_a_robot_file_is_never_replaced_unless_that_is_asked_for(refused: Refused) -> None:
    Path("my.toml").write_text("filled in by hand")
    command = ["robot", "my.urdf", "--no-picture"]
    refused(command, "my.toml: already exists; --overwrite replaces it")
    assert Path("my.toml").read_text() == "filled in by hand"
    assert main([*command, "--overwrite"]) == 0
    assert read_robot("my.toml").name == "my"


@pytest.mark.parametrize("robot", ["two_arm", "cmu_humanoid", "mine.toml"])
def test_a_robot_that_has_a_file_is_shown_only(
    robot: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["robot", "my.urdf", "--no-picture", "--out", "mine.toml"]) == 0
    before = sorted(Path().iterdir())
    assert main(["robot", robot, "--no-picture"]) == 0
    assert sorted(Path().iterdir()) == before
    assert f"next: mpma imitate ymca --robot {robot}" in capsys.readouterr().out.splitlines()[-1]


def test_ranges_that_are_not_mirrored_are_pointed_out(capsys: pytest.CaptureFixture[str]) -> None:
    Path("inward.xml").write_text(figure(ranges={"roll": "0 3"}))  # of the right arm, too
    assert main(["robot", "inward.xml", "--no-picture"]) == 0
    assert (
        "where the model's ranges are not mirrored, give [model.range]" in capsys.readouterr().out
    )
    assert main(["robot", "my.xml", "--no-picture"]) == 0
    assert "mirrored" not in capsys.readouterr().out


def test_a_complete_model_is_a_robot_of_one_line() -> None:
    assert main(["robot", str(TWO_ARM_MODEL), "--no-picture", "--name", "ours"]) == 0
    assert read_robot("ours.toml").complete


def test_joints_and_up_can_be_given(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--left", *LEFT, "--right", *RIGHT, "--wrist", "tip", "--up", "-z", "--name", "given"]
    assert main(["robot", "my.xml", "--no-picture", *words]) == 0
    robot = read_robot("given.toml")
    assert (robot.joints, robot.wrists, robot.up) == ((*LEFT, *RIGHT), None, (0.0, 0.0, -1.0))
    assert "guessed" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nothing.xml"], "nothing.xml: no such file; check the path"),
        (["two_arn"], "--robot is 'two_arn'; expected one of "),
        (["mine.toml"], "mine.toml: no such file; check the path"),
        (["my.xml", "--out", "my.json"], "--out is 'my.json'; expected a file name that ends in"),
        (["my.xml", "--name", "a b"], "--name is 'a b'; expected letters, digits, _ and -"),
        (["two_arm", "--up", "z"], "--up is for a model; a robot file says it itself"),
        (["my.xml", "--left", *LEFT[:3], "--right", *RIGHT], "--left has 3 joints (left_pitch, "),
        (["my.xml", "--left", *LEFT], "--right is missing; expected four joints, from the"),
        (["my.xml", "--up", "w"], "--up"),
        (["my.xml", "--up", "y"], "--up points along the line of the shoulders"),
        (["one.xml"], "one.xml: has one arm only"),
        (["two.xml"], "two.xml: has limbs of 3 hinges (left_pitch, left_roll, left_elbow), 2 of"),
        (["flat.xml"], "flat.xml: the range of joint left_elbow is -0.04363 to 0.0017"),
    ],
)
def test_bad_input_is_refused_in_one_line(words: list[str], message: str, refused: Refused) -> None:
    Path("one.xml").write_text(figure(arms=("left",)))
    two = {"pitch": "0 1 0", "roll": "1 0 0", "elbow": "0 1 0"}
    Path("two.xml").write_text(figure(arm=two, wrist=()))
    Path("flat.xml").write_text(figure().replace('angle="radian"', 'angle="degree"'))
    refused(["robot", *words, "--no-picture"], message)
    assert not list(Path().glob("*.toml"))


def test_the_command_line_itself_finds_arms(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mpma_mj", "robot", "my.xml", "--no-picture"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"right     {', '.join(RIGHT)}" in done.stdout
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 2
