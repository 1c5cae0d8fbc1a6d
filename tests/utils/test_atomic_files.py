import json
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import CheckpointError, RunFolderError
from mpma_mj.utils import atomic_files


def test_arrays_and_their_description_go_round(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.npz"
    arrays = {"x": np.arange(6.0).reshape(2, 3), "n": np.array(3)}
    atomic_files.write_arrays(path, "thing", arrays, {"labels": ["Y", "Ø"]})
    again, meta = atomic_files.read_arrays(path, "thing")
    np.testing.assert_array_equal(again["x"], arrays["x"])
    assert again.keys() == arrays.keys()
    assert meta["labels"] == ["Y", "Ø"]


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    atomic_files.write_text(path, "old")
    failure = pytest.raises(RunFolderError, match="No space left on device")
    with failure, atomic_files.atomic_write(path) as temporary:
        temporary.write_text("half")
        raise OSError(28, "No space left on device")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_not_finite_becomes_null(tmp_path: Path) -> None:
    atomic_files.write_json(tmp_path / "a.json", {"x": float("nan"), "y": {"z": [1.0, np.inf]}})
    content = json.loads((tmp_path / "a.json").read_text())
    assert content == {"x": None, "y": {"z": [1.0, None]}}


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunFolderError, match="cannot be written"):
        atomic_files.write_text(tmp_path / "file" / "a.txt", "x")


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(tmp_path: Path, share: float) -> None:
    path = tmp_path / "a.npz"
    atomic_files.write_arrays(path, "thing", {"x": np.arange(1000.0)}, {})
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(CheckpointError, match="damaged"):
        atomic_files.read_arrays(path, "thing")


def test_flipped_bytes_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    atomic_files.write_arrays(path, "thing", {"x": np.arange(1000.0)}, {})
    spoilt = bytearray(path.read_bytes())
    spoilt[4000] ^= 0xFF
    path.write_bytes(spoilt)
    with pytest.raises(CheckpointError, match="damaged"):
        atomic_files.read_arrays(path, "thing")


def test_foreign_arrays_and_other_kinds_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "foreign.npz", x=np.arange(3))
    with pytest.raises(CheckpointError, match="not a thing"):
        atomic_files.read_arrays(tmp_path / "foreign.npz", "thing")
    atomic_files.write_arrays(tmp_path / "other.npz", "other", {}, {})
    with pytest.raises(CheckpointError, match="not a thing"):
        atomic_files.read_arrays(tmp_path / "other.npz", "thing")
    with pytest.raises(CheckpointError, match="missing"):
        atomic_files.read_arrays(tmp_path / "gone.npz", "thing")


def test_another_format_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(atomic_files, "FORMAT", 99)
    atomic_files.write_arrays(tmp_path / "new.npz", "thing", {}, {})
    monkeypatch.undo()
    with pytest.raises(CheckpointError, match=f"not a thing of format {atomic_files.FORMAT}"):
        atomic_files.read_arrays(tmp_path / "new.npz", "thing")


def test_pickled_objects_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "pickle.npz", meta=np.array("{}"), x=np.array([{}], dtype=object))
    with pytest.raises(CheckpointError, match="damaged"):
        atomic_files.read_arrays(tmp_path / "pickle.npz", "thing")
