"""Files of a folder that are recordings."""

import json
from pathlib import Path

import pytest

from mpma_mj.errors import MotionFileError, RecordingWarning
from mpma_mj.training.dataset import expand_folders

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
