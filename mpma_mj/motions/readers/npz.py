"""Reader for NumPy archives (.npz): named points, an array of joints, or a body's pose."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Collection, Sequence
from pathlib import Path
from tokenize import TokenError  # of a header that NumPy takes for Python 2
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers import joint_arrays, smpl
from mpma_mj.motions.readers.cells import positive
from mpma_mj.motions.readers.foreign_formats import refuse_zip
from mpma_mj.motions.readers.missing_samples import mark_missing
from mpma_mj.motions.readers.recording import UNITS, UPS, Recording, Tracks
from mpma_mj.motions.readers.tables.titles import is_rate

__all__ = ["is_archive", "read_archive", "read_arrays"]

Arrays = dict[str, NDArray[Any]]

_DAMAGED = (
    *(OSError, EOFError, LookupError, ValueError, RuntimeError, MemoryError, struct.error),
    *(zipfile.BadZipFile, zlib.error, SyntaxError, TokenError, NotImplementedError),
)
_LARGEST = 1 << 30  # bytes that arrays may unpack to


def is_archive(head: bytes) -> bool:
    """Return whether the first bytes are those of a NumPy archive."""
    return head.startswith(b"PK\x03\x04")


def read_archive(path: Path, only: Collection[str] = ()) -> Arrays:
    """Read arrays of an archive.

    Args:
        path: The archive.
        only: Names of those that are read, if they are there; all by default.

    Raises:
        MotionFileError: It is another ZIP archive, damaged, or holds more than numbers and texts.
    """
    refuse_zip(path)
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            size = sum(entry.file_size for entry in file.zip.infolist())
            if size > _LARGEST and not only:
                raise MotionFileError(
                    f"{path}: unpacks to {size / 2**30:.1f} GB; keep the arrays of one recording"
                )
            names = [name for name in file.files if name in only or not only]
            arrays = {name: file[name] for name in names}
    except _DAMAGED:
        arrays = {}
    if not (arrays or only) or not all(isinstance(array, np.ndarray) for array in arrays.values()):
        raise MotionFileError(
            f"{path}: is a damaged archive, or not one of NumPy arrays; write it again"
        )
    return arrays


def read_arrays(
    path: Path, arrays: Arrays, report: ImportReport, skeleton: Path | None
) -> Recording:
    """Read the pose parameters of a body, an array of joints, or points by name.

    Args:
        path: The archive.
        arrays: Its content, with the frame rate, and perhaps `unit` and `up`.
        report: Gets what is found.
        skeleton: Archive of a body model, for a pose.

    Raises:
        MotionFileError: An array has not the shape that it needs.
    """
    rate = _read_rate(path, arrays)
    pose = smpl.find_pose(path, arrays)
    if pose is not None:
        model = None if skeleton is None else read_archive(skeleton, smpl.MODEL_ARRAYS)
        return smpl.read_pose(path, pose, model, rate, report, skeleton)
    unit, up = (_declared(path, arrays, *known) for known in (("unit", UNITS), ("up", UPS)))
    declared: dict[str, Any] = {
        "rate": rate,
        "unit": UNITS.get(unit),
        "up": next((known for known in UPS if known == up), None),
    }
    points = {
        name: np.array(array, np.float64)
        for name, array in arrays.items()
        if array.ndim == 2 and array.shape[1] == 3 and array.dtype.kind in "fiu"
    }
    joints = joint_arrays.find_joints(path, arrays)
    if joints is not None and len(points) < joint_arrays.FEWEST:
        return joint_arrays.read_joints(path, joints, report, format_name="npz", **declared)
    if not points or len({len(track) for track in points.values()}) > 1:
        raise MotionFileError(
            f"{path}: expected arrays of shape (T, 3) with one T, named like left_wrist, or one of"
            " shape (T, J, 3), and rate; it has"
            f" {', '.join(f'{n} {a.shape}' for n, a in arrays.items()) or 'nothing'}"
        )

    def load(names: Sequence[str]) -> Tracks:
        tracks = {name: points[name] for name in names}
        mark_missing(tracks, report)
        return tracks

    return Recording(path, "npz", tuple(points), load, **declared)


def _text(array: NDArray[Any]) -> str:
    """Return the only entry of an array, or ""."""
    return str(array.reshape(-1)[0]) if array.size == 1 else ""


def _read_rate(path: Path, arrays: Arrays) -> float | None:
    """Return the frame rate, Hz, if an array is named so."""
    found = {name: array for name, array in arrays.items() if is_rate(name)}
    rates = {name: positive(_text(array)) for name, array in found.items()}
    for name, rate in rates.items():
        if rate is None:
            raise MotionFileError(
                f"{path}: {name} is '{str(found[name])[:40]}'; expected a number above 0"
            )
    if len(set(rates.values())) > 1:
        given = " and ".join(f"{name} {rate:g}" for name, rate in rates.items())
        raise MotionFileError(f"{path}: has {given}, which contradict each other; keep one")
    return next(iter(rates.values()), None)


def _declared(path: Path, arrays: Arrays, name: str, known: Collection[str]) -> str:
    """Return the text of an array, one of those known, or "" if there is none."""
    text = _text(arrays[name]) if name in arrays and arrays[name].ndim < 2 else ""
    if text not in ("", *known):
        raise MotionFileError(
            f"{path}: {name} is '{text[:40]}'; expected one of {', '.join(known)}"
        )
    return text
