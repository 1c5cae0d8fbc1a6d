import io
import json
import os
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

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
        lambda text: '{"x": ' * 900 + "1" + "}" * 900,
        lambda text: text.replace('"digest"', '"format": ' + "9" * 4000 + ', "digest"'),
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
    with pytest.raises(CheckpointError, match="a: is a pipe") as refused:
        data_files.read_arrays(tmp_path / "a", "thing")
    message = str(refused.value)
    assert message.endswith("a: is a pipe, not a file; train again with overwrite"), message
    assert not data_files.is_json(tmp_path / "a", set())
    assert not data_files.is_archive(tmp_path / "a", "thing")


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


def members(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def header(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    """Return the header of an array, which may promise anything."""
    stream = io.BytesIO()
    content = {"shape": shape, "fortran_order": False, "descr": kind}
    np.lib.format.write_array_header_1_0(stream, content)
    return stream.getvalue()


@pytest.mark.parametrize(
    "x",
    [
        header((10**12,)),
        header((10**9, 12)) + bytes(96),
        header((-1, -1)) + bytes(8),
        header((5,)) + bytes(48),
        header((5,)) + bytes(32),
        header((2,), "|O") + bytes(16),
        b"\x93NUMPY\x02\x00" + bytes(40),
        b"hello",
        b"",
    ],
)
def test_an_array_has_the_bytes_that_its_header_says(tmp_path: Path, x: bytes) -> None:
    path = tmp_path / "a.npz"
    data_files.write_arrays(path, "thing", {"x": np.arange(5.0)}, {})
    content = members(path) | {"x.npy": x}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    tracemalloc.start()
    with pytest.raises(CheckpointError, match="damaged"):
        data_files.read_arrays(path, "thing")
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    tracemalloc.stop()


def test_objects_are_not_made_of_bytes_of_whatever_digest(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("x.npy", header((2,), "|O") + bytes(16))
    with pytest.raises(ValueError, match="another number of bytes"):
        data_files._read_archive(tmp_path / "a.npz")


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, meta=np.array("{}"), x=np.zeros(20_000_000))
    tracemalloc.start()
    with pytest.raises(CheckpointError, match="damaged"):
        data_files.read_arrays(path, "thing")
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    tracemalloc.stop()


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_damage_of_a_compressed_archive_is_no_fault(tmp_path: Path, method: int) -> None:
    path = tmp_path / "a.npz"
    content = np.random.default_rng(0).bytes(20_000)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", header((2500,)) + content, method)
        archive.writestr("room", bytes(1000))
    for place in range(100, 20_000, 1000):
        data = bytearray(path.read_bytes())
        data[place : place + 50] = bytes(50)
        (tmp_path / "b.npz").write_bytes(data)
        with pytest.raises(CheckpointError, match="damaged"):
            data_files.read_arrays(tmp_path / "b.npz", "thing")


@pytest.mark.parametrize("change", ["value", "type", "shape", "name", "meta", "more", "less"])
def test_arrays_written_by_something_else_are_refused(tmp_path: Path, change: str) -> None:
    path = tmp_path / "a.npz"
    data_files.write_arrays(path, "thing", {"x": np.arange(6.0), "y": np.ones(1)}, {"n": 1})
    with np.load(path) as file:
        arrays = dict(file)
    if change == "value":
        arrays["x"][3] += 1e-9
    if change == "type":
        arrays["y"] = arrays["y"].view(np.int64)
    if change == "shape":
        arrays["x"] = arrays["x"].reshape(2, 3)
    if change == "name":
        arrays["z"] = arrays.pop("y")
    if change == "meta":
        arrays["meta"] = np.array(str(arrays["meta"]).replace('"n": 1', '"n": 2'))
    if change == "more":
        arrays["z"] = np.zeros(1)
    if change == "less":
        del arrays["y"]
    np.savez(path, **arrays)
    with pytest.raises(CheckpointError, match=r"a\.npz: damaged; train again with overwrite"):
        data_files.read_arrays(path, "thing")


@pytest.mark.parametrize(
    "array", [np.zeros(()), np.zeros((0, 3)), np.ones((2, 3)).T, np.array("é")]
)
def test_arrays_come_back_as_they_were_and_can_be_written(tmp_path: Path, array: Any) -> None:
    data_files.write_arrays(tmp_path / "a.npz", "thing", {"x": array}, {})
    again = data_files.read_arrays(tmp_path / "a.npz", "thing")[0]["x"]
    np.testing.assert_array_equal(again, array)
    assert again.dtype == array.dtype
    assert again.flags.writeable
