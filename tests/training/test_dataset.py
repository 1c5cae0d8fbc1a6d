"""Data sets: files of a folder that are recordings, and repertoires."""

import json
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError, RecordingWarning
from mpma_mj.motions import read_motion, save_motion
from mpma_mj.motions.feasible_motion import fitted
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import expand_folders, read_motions
from tests.robots.humanoid import (
    HUMANOID,
    check_limits,
    cut,
    humanoid_limits,
    short_dance,
    without_two_arm,
)

RECORDINGS = ("a.amc", "b.bvh", "c.c3d", "d.csv", "e.mvnx", "f.npy", "g.npz", "h.TRC", "i.tsv")
POINTS = [[[0.1 * i, 0.2, 0.3] for i in range(17)]] * 3


def test_a_folder_is_its_recordings(tmp_path: Path) -> None:
    for name in (*RECORDINGS, "a.asf", "notes.txt", "dance.mp4"):
        (tmp_path / name).write_text("x\n")
    (tmp_path / "folder.bvh").mkdir()
    found = expand_folders(["ymca", str(tmp_path)])
    assert [Path(name).name for name in found] == ["ymca", *RECORDINGS]


@pytest.mark.parametrize("foreign", ["{}", '{"nodes": [1, 2, 3]}', json.dumps(POINTS)[:-9], "x"])
def test_json_of_something_else_is_left_out_with_a_warning(foreign: str, tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text(foreign)
    (tmp_path / "pose.json").write_text(json.dumps(POINTS))
    with pytest.warns(RecordingWarning, match=r"left out: .*config\.json: ") as caught:
        assert expand_folders([str(tmp_path)]) == (str(tmp_path / "pose.json"),)
    assert len(caught) == 1


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("x\n")
    with pytest.raises(MotionFileError, match=r"expected files that end in \.amc, .*\.npy, "):
        expand_folders([str(tmp_path)])


def test_a_repertoire_of_a_robot_is_joined_by_postures_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arms = humanoid_limits().kinematics
    parts = [short_dance(), fitted(cut(read_motion("wave"), 20, 60), humanoid_limits())[0]]
    paths = [str(tmp_path / f"{part.name}.npz") for part in parts]
    for path, part in zip(paths, parts, strict=True):
        save_motion(Path(path), part)
    without_two_arm(monkeypatch)
    motion = read_motions(RunConfig.of(*paths, robot=HUMANOID))
    assert (motion.labels, motion.angles_of) == (("ymca", "wave"), arms.name)
    check_limits(motion.joint_angles, motion.rate)
    first, last = (part.joint_angles for part in parts)
    np.testing.assert_array_equal(motion.joint_angles[: len(first)], first)
    np.testing.assert_array_equal(motion.joint_angles[-len(last) :], last)
    between = slice(len(first), -len(last))
    shown = arms.posture(motion.joint_angles[between])
    assert len(shown) >= 3
    np.testing.assert_allclose(motion.posture[between], shown, atol=1e-9)
