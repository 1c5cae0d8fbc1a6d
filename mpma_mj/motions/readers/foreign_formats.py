"""Formats that are not read: how each is recognised, and the remedy."""

from __future__ import annotations

import zipfile
from pathlib import Path

from mpma_mj.errors import MotionFileError
from mpma_mj.utils.text import listing

__all__ = ["refuse_foreign", "refuse_zip"]

_SCENE = "export it as BVH"
_TABLE = "save the sheet as CSV"
_NUMBERS = "save the points as CSV or npz"
_UNPACK = "unpack it, and give the recording inside"
_PICTURE = "give a recording of points or joints, such as C3D, BVH or CSV"
_SOUND = "give a recording, and sound with {audio}"
_PICKLE = "a Python pickle, which can run code and is never opened"
_SAVE = "save its arrays as npz"

# By the first bytes, at an offset.
_BYTES: dict[tuple[int, bytes], tuple[str, str]] = {
    (0, b"Kaydara FBX"): ("an FBX scene", _SCENE),
    (0, b"glTF"): ("a glTF scene (GLB or VRM)", _SCENE),
    (0, b"PXR-USDC"): ("a USD scene", _SCENE),
    (0, b"BLENDER"): ("a Blender scene", _SCENE),
    (0, b"FOR4"): ("a Maya scene", _SCENE),
    (0, b"Ogawa"): ("an Alembic scene", _SCENE),
    (0, b"Vocaloid Motion Data"): ("a motion of MikuMikuDance (VMD)", _SCENE),
    (0, b"\x89HDF"): ("an HDF5 file, as MATLAB 7.3 writes them, too", _NUMBERS),
    (0, b"MATLAB"): ("a MATLAB file", _NUMBERS),
    (0, b"PAR1"): ("a Parquet table", _NUMBERS),
    (0, b"ARROW1"): ("an Arrow table", _NUMBERS),
    (0, b"FEA1"): ("a Feather table", _NUMBERS),
    (0, b"SQLite format 3"): ("an SQLite database", _NUMBERS),
    (0, b"#ROSBAG"): ("a ROS bag", _NUMBERS),
    (0, b"\x89MCAP"): ("a ROS bag (MCAP)", _NUMBERS),
    (0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"): ("an old Office document, such as .xls", _TABLE),
    (0, b"RIFF"): ("sound or a picture (RIFF)", _SOUND),
    (0, b"ID3"): ("sound (MP3)", _SOUND),
    (0, b"fLaC"): ("sound (FLAC)", _SOUND),
    (0, b"\x89PNG"): ("an image (PNG)", _PICTURE),
    (0, b"\xff\xd8\xff"): ("an image (JPEG)", _PICTURE),
    (0, b"II*\0"): ("an image (TIFF)", _PICTURE),
    (0, b"MM\0*"): ("an image (TIFF)", _PICTURE),
    (0, b"%PDF"): ("a PDF document", _PICTURE),
    (0, b"\x1f\x8b"): ("compressed (gzip)", _UNPACK),
    (0, b"BZh"): ("compressed (bzip2)", _UNPACK),
    (0, b"\xfd7zXZ"): ("compressed (xz)", _UNPACK),
    (0, b"\x28\xb5\x2f\xfd"): ("compressed (zstd)", _UNPACK),
    (0, b"7z\xbc\xaf\x27\x1c"): ("a 7z archive", _UNPACK),
    (0, b"Rar!"): ("a RAR archive", _UNPACK),
    (257, b"ustar"): ("a tar archive", _UNPACK),
    **{(0, bytes([0x80, protocol])): (_PICKLE, _SAVE) for protocol in range(2, 6)},
}

# By how a text begins, in lower case, after white space.
_TEXTS: dict[str, tuple[str, str]] = {
    "; fbx": ("an FBX scene", _SCENE),
    "#usda": ("a USD scene", _SCENE),
    "//maya ascii": ("a Maya scene", _SCENE),
    "xof 03": ("a DirectX scene", _SCENE),
    "<!doctype html": ("a web page", "download the recording itself"),
    "<html": ("a web page", "download the recording itself"),
    "(dp": (_PICKLE, _SAVE),
    "ccopy_reg": (_PICKLE, _SAVE),
    "cnumpy": (_PICKLE, _SAVE),
    "version https://git-lfs": ("a placeholder of Git LFS", "fetch it with git lfs pull"),
}

# By what is in a ZIP archive: the beginning or the end of a name.
_ZIPPED: dict[str, tuple[str, str]] = {
    "xl/": ("an Excel workbook", _TABLE),
    "word/": ("a Word document", _PICTURE),
    "ppt/": ("a PowerPoint document", _PICTURE),
    "Index/": ("a Numbers or Pages document", _TABLE),
    "content.xml": ("an OpenDocument sheet or text", _TABLE),
    ".usdc": ("a USD scene", _SCENE),
    ".usda": ("a USD scene", _SCENE),
    "data.pkl": ("a PyTorch file, which can run code and is never opened", _SAVE),
}
_TEXT = 512  # bytes within which a text shows what it is
_MOST_LISTED = 3  # names in a message


def refuse_foreign(path: Path, head: bytes) -> None:
    """Refuse a file of a format that is not read, by its first bytes.

    Raises:
        MotionFileError: It is one; the message names the format and a remedy.
    """
    text = head[:_TEXT].decode("utf-8-sig", errors="replace").lstrip().lower()
    found = next((f for (at, sign), f in _BYTES.items() if head.startswith(sign, at)), None)
    found = found or next((f for start, f in _TEXTS.items() if text.startswith(start)), None)
    if found is not None:
        raise MotionFileError(f"{path}: is {found[0]}", remedy=found[1])


def refuse_zip(path: Path) -> None:
    """Refuse a ZIP archive that holds no NumPy arrays.

    Raises:
        MotionFileError: It is one; the message names its content.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name for name in archive.namelist() if not name.endswith("/")]
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return  # damaged, which its reader reports
    for sign, (what, remedy) in _ZIPPED.items():
        if any(name.startswith(sign) or name.endswith(sign) for name in names):
            raise MotionFileError(f"{path}: is {what}", remedy=remedy)
    if names and not any(name.endswith(".npy") for name in names):
        listed = listing(names, _MOST_LISTED)
        raise MotionFileError(f"{path}: is a ZIP archive with {listed}", remedy=_UNPACK)
