"""Picture of a robot in plain poses."""

from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from mpma_mj.robots.new_robot import describe_model
from mpma_mj.robots.report import RobotReport
from mpma_mj.visualization.robot_poses import write_poses
from tests.robots.figures import figure


def columns(path: Path) -> list[np.ndarray]:
    """Return the four parts of a page, from left to right."""
    page = imageio.imread(path)[:, :, :3].astype(float)
    return np.array_split(page[:, : page.shape[1] // 4 * 4], 4, axis=1)


def coloured(part: np.ndarray, colour: str) -> np.ndarray:
    """Return the columns of pixels of a part that are clearly blue or orange."""
    more_blue = part[:, :, 2] - part[:, :, 0]
    clearly = more_blue > 120.0 if colour == "blue" else more_blue < -120.0
    return np.flatnonzero(clearly.any(axis=0))


@pytest.mark.usefixtures("opengl")
def test_the_left_arm_is_drawn_on_the_right_in_each_pose(tmp_path: Path) -> None:
    (tmp_path / "grey.xml").write_text(figure())
    robot = describe_model(tmp_path / "grey.xml", name="grey").robot
    report = RobotReport(robot)
    path = tmp_path / "poses.png"
    write_poses(path, report.model, robot.joints, report.poses, "grey")
    parts = columns(path)
    for part in parts:
        left, right = coloured(part, "blue"), coloured(part, "orange")
        assert len(left) > 3
        assert len(right) > 3
        assert left.mean() > right.mean()  # seen from in front
    widths = [np.ptp(np.concatenate([coloured(p, "blue"), coloured(p, "orange")])) for p in parts]
    assert widths[0] > 1.5 * max(widths[1:3])  # T-pose, then down and up
    assert not np.array_equal(parts[1], parts[2])
