"""Report on a robot: poses, reach and what is unknown."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.motions import ymca
from mpma_mj.robots.poses import POSES
from mpma_mj.robots.report import PoseResult, RobotReport
from mpma_mj.robots.robot import JointValues, Robot
from mpma_mj.robots.robot_file import read_robot
from tests.robots.small_robot import write_small_robot


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    return read_robot(write_small_robot(tmp_path))


def test_the_small_robot_reaches_all(robot: Robot) -> None:
    report = RobotReport(robot)
    assert list(report.poses) == list(POSES)
    for result in report.poses.values():
        assert result.deviations.max() < 1.2  # its elbow is askew
        assert str(result) == f"{result.deviations[0]:.1f}° off"
    assert report.reachable(ymca().posture) == (1.0, 1.0)
    lines = "\n".join(report.lines() + report.physical_lines({}))
    for text in (
        "small: Small robot, ",
        "left      l_pitch, l_roll, l_yaw, l_elbow",
        "forearms  end at l_wrist, r_wrist",
        "left upper arm 0.300 m, forearm 0.250 m",
        "left -229…229°",
        "speed     9, 8, 7, 6 rad/s (data sheet)",
    ):
        assert text in lines
    assert report.unknown == []


def test_unknown_speeds_do_not_hinder(robot: Robot) -> None:
    physical = dict(robot.physical) | {"speed": JointValues(), "damping": JointValues()}
    report = RobotReport(dataclasses.replace(robot, physical=physical))
    assert report.unknown == ["speed", "damping"]
    lines = report.physical_lines({"damping": "my.xml has 7, 7, 7, 7; often invented"})
    assert lines[0] == "speed     unknown"
    assert lines[3] == "damping   unknown; my.xml has 7, 7, 7, 7; often invented"


def test_poses_out_of_reach_are_named() -> None:
    def shown(*degrees: float) -> str:
        return str(PoseResult(np.zeros(8), np.zeros((2, 6)), np.array(degrees)))

    assert shown(0.04, 0.0) == "0.0° off"
    assert shown(1.0, 2.0) == "left 1.0°, right 2.0° off"
    assert shown(7.0, 7.0) == "7.0° off, out of reach"


def test_two_arm_has_its_values_in_the_model() -> None:
    report = RobotReport(read_robot("two_arm"))
    assert report.unknown == []
    assert report.physical_lines({}) == ["physical  as the model has it"]
    assert report.reachable(ymca().posture) == (1.0, 1.0)
