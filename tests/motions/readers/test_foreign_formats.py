"""Files of formats that are not read are refused by their true name, with the way out."""

import gzip
import io
import pickle
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.loader import read_motion


def zipped(*names: str) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name in names:
            archive.writestr(name, "content")
    return content.getvalue()


def packed() -> bytes:
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        archive.addfile(tarfile.TarInfo("dance.bvh"))
    return content.getvalue()


def image(kind: str) -> bytes:
    content = io.BytesIO()
    Image.new("RGB", (40, 40)).save(content, kind)
    return content.getvalue()


BOOK = ("[Content_Types].xml", "_rels/.rels", "xl/workbook.xml", "xl/worksheets/sheet1.xml")

FOREIGN = {
    "xlsx": (zipped(*BOOK), "is an Excel workbook; save the sheet as CSV"),
    "xls": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600), "is an old Office .* as CSV"),
    "ods": (zipped("mimetype", "content.xml"), "is an OpenDocument sheet or text; save the sheet"),
    "docx": (zipped("[Content_Types].xml", "word/document.xml"), "is a Word document"),
    "zip": (zipped("a/", "a/one.bvh", "a/two.bvh"), r"is a ZIP archive with a/one\.bvh, a/two"),
    "zip of many": (zipped(*"abcdef"), "with a, b, c and 3 more; unpack it, and give the rec"),
    "pt": (zipped("model/data.pkl", "model/data/0"), "PyTorch file, which can run code"),
    "usdz": (zipped("scene.usdc"), "is a USD scene; export it as BVH"),
    "usda": (b"#usda 1.0\n(\n)\n", "is a USD scene"),
    "fbx": (b"Kaydara FBX Binary  \0\x1a\0", "is an FBX scene; export it as BVH"),
    "fbx text": (b"; FBX 7.3.0 project file\n; ----\n", "is an FBX scene; export it as BVH"),
    "glb": (b"glTF\x02\0\0\0" + bytes(40), "is a glTF scene"),
    "vmd": (b"Vocaloid Motion Data 0002" + bytes(40), "MikuMikuDance"),
    "blend": (b"BLENDER-v300" + bytes(40), "is a Blender scene"),
    "mat": (b"MATLAB 5.0 MAT-file, Platform", "is a MATLAB file; save the points as CSV or npz"),
    "h5": (b"\x89HDF\r\n\x1a\n" + bytes(40), "is an HDF5 file"),
    "parquet": (b"PAR1" + bytes(40), "is a Parquet table"),
    "pkl 2": (pickle.dumps([1], 2), "is a Python pickle, .* never opened; save its arrays as npz"),
    "pkl 5": (pickle.dumps({"poses": np.ones(9)}, 5), "is a Python pickle"),
    "pkl 0": (pickle.dumps({"poses": 1}, 0), "is a Python pickle"),
    "pdf": (b"%PDF-1.7\n", "is a PDF document"),
    "html": (b"\n<!DOCTYPE html>\n<html></html>", "is a web page; download the recording"),
    "png": (image("PNG"), r"is an image \(PNG\)"),
    "jpg": (image("JPEG"), r"is an image \(JPEG\)"),
    "wav": (b"RIFF\0\0\0\0WAVE", "is sound or a picture .* sound with audio"),
    "gz": (gzip.compress(b"HIERARCHY\n"), r"is compressed \(gzip\); unpack it"),
    "7z": (b"7z\xbc\xaf\x27\x1c" + bytes(40), "is a 7z archive; unpack it"),
    "rar": (b"Rar!\x1a\x07" + bytes(40), "is a RAR archive; unpack it"),
    "tar": (packed(), "is a tar archive; unpack it"),
    "6D": (
        b"NO_OF_FRAMES\t2\nNO_OF_BODIES\t1\nDATA_INCLUDED\t6D\nBODY_NAMES\tHand\n",
        "holds 6D, such as rotations of bodies, and no markers; export the 3D data",
    ),
    "lfs": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "git lfs pull"),
}


@pytest.mark.parametrize("kind", FOREIGN)
@pytest.mark.parametrize("ending", ["csv", "npz"])
def test_it_is_refused_by_its_name(tmp_path: Path, kind: str, ending: str) -> None:
    content, message = FOREIGN[kind]
    path = tmp_path / f"dance.{ending}"
    path.write_bytes(content)
    with pytest.raises(MotionFileError, match=message) as caught:
        read_motion(path)
    assert len(str(caught.value).splitlines()) == 1
    assert "damaged" not in str(caught.value)


def test_an_archive_of_arrays_is_none_of_them(tmp_path: Path) -> None:
    (tmp_path / "dance.npz").write_bytes(zipped("left_wrist.npy"))
    with pytest.raises(MotionFileError, match="is a damaged archive"):
        read_motion(tmp_path / "dance.npz")
