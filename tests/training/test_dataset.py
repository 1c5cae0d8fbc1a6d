"""Files of a folder that are recordings."""

from pathlib import Path

import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.training.dataset import expand_folders

RECORDINGS = ("a.amc", "b.bvh", "c.c3d", "d.csv", "e.mvnx", "f.npy", "g.npz", "h.TRC", "i.tsv")


def test_a_folder_is_its_recordings(tmp_path: Path) -> None:
    for name in (*RECORDINGS, "a.asf", "notes.txt", "config.json", "dance.mp4"):
        (tmp_path / name).write_text("x\n")
    found = expand_folders(["ymca", str(tmp_path)])
    assert [Path(name).name for name in found] == ["ymca", *RECORDINGS]


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("x\n")
    with pytest.raises(MotionFileError, match=r"expected files that end in \.amc, .*\.npy, "):
        expand_folders([str(tmp_path)])
