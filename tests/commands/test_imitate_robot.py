"""Runs of other robots as a user types them: trained, continued, analysed and evaluated."""

from pathlib import Path

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.robots.robot_file import CATALOGUE
from mpma_mj.training.run_folder import RunFolder
from tests.conftest import Refused

ROBOT = "cmu_humanoid"
WORDS = ["imitate", "ymca", "--robot", ROBOT, "--no-video", "--repeats", "2", "--nodes", "10"]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "robot"
    assert main([*WORDS, "--epochs", "1", "--out", str(folder)]) == 0
    return folder


def test_a_run_keeps_its_robot(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = RunFolder(run)
    assert folder.read_config().env.robot == ROBOT
    motion = folder.read_motion()
    assert motion.feasible_angles is not None
    assert motion.angles_of.startswith(ROBOT)
    assert main(["imitate", "--resume", str(run), "--epochs", "2", "--no-video"]) == 0
    assert "epoch   2" in capsys.readouterr().err
    again = folder.read_motion().joint_angles
    np.testing.assert_array_equal(again, motion.joint_angles)


def test_joints_have_the_names_of_the_robot(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["analyse", str(run), "modules"]) == 0
    assert "| joint lhumerusrz |" in capsys.readouterr().out
    words = ["evaluate", str(run), "--disturbances", "locked", "--no-baselines"]
    assert main([*words, "--levels", "none", "lradiusrx"]) == 0
    assert "| locked joint | lradiusrx |" in capsys.readouterr().out


def test_a_joint_of_another_robot_is_no_level(run: Path, refused: Refused) -> None:
    words = ["evaluate", str(run), "--disturbances", "locked", "--levels", "left_elbow"]
    refused(words, "locked has no level 'left_elbow'; expected some of none, lhumerusrz, ")


def test_a_robot_that_has_changed_is_another(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    refused: Refused,
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (CATALOGUE / f"{ROBOT}.toml").read_text()
    file = tmp_path / "own.toml"
    file.write_text(text)
    assert main([*WORDS, "--robot", "own.toml", "--epochs", "1", "--out", "run"]) == 0
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert main(["imitate", "--resume", "../run", "--epochs", "2", "--no-video"]) == 0
    file.write_text(text.replace("[12.0, 20.0, 12.0, 15.0]", "[12.0, 20.0, 12.0, 14.0]"))
    message = "cmu_humanoid is not what it was: its robot file or its model has changed"
    refused(["imitate", "--resume", "../run", "--epochs", "3", "--no-video"], message)
    begun = [*WORDS, "--robot", str(file), "--init", "../run", "--epochs", "1", "--out", "new"]
    capsys.readouterr()
    assert main(begun) == 2
    assert message in capsys.readouterr().err.splitlines()[-1]
    refused(["evaluate", "../run", "--disturbances", "noise", "--levels", "0"], message)
    for name in ("x.csv", "x.webp"):
        refused(["play", "../run", "--out", name], message)
    file.write_text(text.replace('name = "cmu_humanoid"', 'name = "other"'))
    refused(["play", "../run", "--out", "x.csv"], message)
    refused(["evaluate", "../run", "--disturbances", "noise", "--levels", "0"], message)


def test_a_robot_of_unknown_forces_is_evaluated_as_ideal_arms(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], refused: Refused
) -> None:
    text = (CATALOGUE / f"{ROBOT}.toml").read_text()
    file, out = tmp_path / "own.toml", str(tmp_path / "run")
    file.write_text(text[: text.index("[force]")])
    words = [*WORDS, "--robot", str(file), "--epochs", "1", "--out", out]
    refused(words, "force of the joints, N m, is unknown; choose --arms kinematic, or give [force]")
    assert main([*words, "--arms", "kinematic"]) == 0
    levels = ["--disturbances", "latency", "--levels", "0", "--no-baselines"]
    message = "are unknown: armature, damping, force, kv; choose --arms kinematic"
    refused(["evaluate", out, *levels], message)
    capsys.readouterr()
    assert main(["evaluate", out, *levels, "--arms", "kinematic"]) == 0


def test_a_robot_that_is_too_slow_learns_which_tempo_would_do(
    tmp_path: Path, refused: Refused, capsys: pytest.CaptureFixture[str]
) -> None:
    file, text = tmp_path / "slow.toml", (CATALOGUE / f"{ROBOT}.toml").read_text()
    file.write_text(text.replace("[12.0, 20.0, 12.0, 15.0]", "[3.0, 5.0, 3.0, 3.75]"))
    words = [*WORDS, "--robot", str(file), "--arms", "kinematic"]
    refused([*words, "--strict"], "% of the steps within 5°, this one ")
    refused([*words, "--strict"], "; leave out --strict")
    assert main(["motion", "ymca", "--robot", str(file), "--tempo", "auto"]) == 0
    assert "of this tempo" not in capsys.readouterr().out


def test_an_unknown_robot_is_answered_with_the_nearest(refused: Refused) -> None:
    refused(["imitate", "ymca", "--robot", "cmu"], "--robot is 'cmu'; expected one of cmu_humanoid")
