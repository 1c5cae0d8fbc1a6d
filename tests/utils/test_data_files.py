import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import CheckpointError
from mpma_mj.utils import data_files


def test_arrays_and_their_description_go_round(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.npz"
    arrays = {"x": np.arange(6.0).reshape(2, 3), "n": np.array(3)}
    data_files.write_arrays(path, "thing", arrays, {"labels": ["Y", "Ø"]})
    again, meta = data_files.read_arrays(path, "thing")
    np.testing.assert_array_equal(again["x"], arrays["x"])
    assert again.keys() == arrays.keys()
    assert meta["labels"] == ["Y", "Ø"]


def test_what_is_not_finite_becomes_null(tmp_path: Path) -> None:
    data_files.write_json(tmp_path / "a.json", {"x": float("nan"), "y": {"z": [1.0, np.inf]}})
    content = json.loads((tmp_path / "a.json").read_text())
    content.pop("digest")
    assert content == {"x": None, "y": {"z": [1.0, None]}}


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text.replace("1.5", "1.6"),
        lambda text: text.replace('"digest"', '"digests"'),
        lambda text: text[:-3],
        lambda text: "[" * 100_000 + "]" * 100_000,
        lambda text: text.replace("1.5", "9" * 5000),
        lambda text: text.replace("1.5", "1.5e999"),
        lambda text: "null",
        lambda text: "[]",
    ],
)
def test_damaged_json_is_refused(tmp_path: Path, damage: Callable[[str], str]) -> None:
    path = tmp_path / "a.json"
    data_files.write_json(path, {"x": [1.5, None], "é": {"y": "text"}})
    assert data_files.read_json(path) == {"x": [1.5, None], "é": {"y": "text"}}
    path.write_text(damage(path.read_text()))
    with pytest.raises(ValueError, match="damaged"):
        data_files.read_json(path)


def test_a_pipe_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a")
    with pytest.raises(ValueError, match="is a pipe"):
        data_files.read_json(tmp_path / "a")
    with pytest.raises(CheckpointError, match="a: is a pipe"):
        data_files.read_arrays(tmp_path / "a", "thing")


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(tmp_path: Path, share: float) -> None:
    path = tmp_path / "a.npz"
    data_files.write_arrays(path, "thing", {"x": np.arange(1000.0)}, {})
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(CheckpointError, match="damaged"):
        data_files.read_arrays(path, "thing")


def test_flipped_bytes_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    data_files.write_arrays(path, "thing", {"x": np.arange(1000.0)}, {})
    spoilt = bytearray(path.read_bytes())
    spoilt[4000] ^= 0xFF
    path.write_bytes(spoilt)
    with pytest.raises(CheckpointError, match="damaged"):
        data_files.read_arrays(path, "thing")


def test_foreign_arrays_and_other_kinds_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "foreign.npz", x=np.arange(3))
    with pytest.raises(CheckpointError, match="not a thing"):
        data_files.read_arrays(tmp_path / "foreign.npz", "thing")
    data_files.write_arrays(tmp_path / "other.npz", "other", {}, {})
    with pytest.raises(CheckpointError, match="not a thing"):
        data_files.read_arrays(tmp_path / "other.npz", "thing")
    with pytest.raises(CheckpointError, match="missing"):
        data_files.read_arrays(tmp_path / "gone.npz", "thing")


def test_another_format_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_files, "FORMAT", 99)
    data_files.write_arrays(tmp_path / "new.npz", "thing", {}, {})
    monkeypatch.undo()
    with pytest.raises(CheckpointError, match=f"not a thing of format {data_files.FORMAT}"):
        data_files.read_arrays(tmp_path / "new.npz", "thing")


def test_pickled_objects_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "pickle.npz", meta=np.array("{}"), x=np.array([{}], dtype=object))
    with pytest.raises(CheckpointError, match="damaged"):
        data_files.read_arrays(tmp_path / "pickle.npz", "thing")
