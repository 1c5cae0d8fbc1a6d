"""Reader for points in a NumPy archive (.npz): an array of shape (T, 3) for each."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers.recording import UNITS, UPS, Recording, Tracks
from mpma_mj.motions.readers.text import positive, printable

__all__ = ["is_archive", "read_archive", "read_points"]


_DAMAGED = (
    *(OSError, EOFError, LookupError, ValueError, RuntimeError, MemoryError, struct.error),
    *(zipfile.BadZipFile, zlib.error),
)


def is_archive(head: bytes) -> bool:
    """Return whether the first bytes are those of a NumPy archive."""
    return head.startswith(b"PK\x03\x04")


def read_archive(path: Path) -> dict[str, NDArray[Any]]:
    """Read all arrays of an archive.

    Raises:
        MotionFileError: It is damaged, or holds more than numbers and texts.
    """
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            arrays = {printable(name): file[name] for name in file.files}
    except _DAMAGED:
        arrays = {}
    if not arrays or not all(isinstance(array, np.ndarray) for array in arrays.values()):
        raise MotionFileError(
            f"{path}: is a damaged archive, or not one of NumPy arrays; write it again"
        )
    return arrays


def read_points(path: Path, arrays: dict[str, NDArray[Any]]) -> Recording:
    """Read points by name, with `rate`, and perhaps `unit` and `up`.

    Raises:
        MotionFileError: An array has not the shape that it needs.
    """
    points = {
        name: np.array(array, np.float64)
        for name, array in arrays.items()
        if array.ndim == 2 and array.shape[1] == 3 and array.dtype.kind in "fiu"
    }
    if not points or len({len(track) for track in points.values()}) > 1:
        raise MotionFileError(
            f"{path}: expected arrays of shape (T, 3) with one T, named like left_wrist, and rate;"
            f" it has {', '.join(f'{n} {a.shape}' for n, a in arrays.items()) or 'nothing'}"
        )

    def text(name: str) -> str:
        return str(arrays[name]) if name in arrays and arrays[name].ndim == 0 else ""

    def load(names: Sequence[str]) -> Tracks:
        for name in names:
            track = points[name]
            track[~(np.isfinite(track).all(axis=1) & track.any(axis=1))] = np.nan
        return {name: points[name] for name in names}

    rate = text("rate")
    if rate and positive(rate) is None:
        raise MotionFileError(
            f"{path}: rate is '{printable(rate[:40])}'; expected a number above 0"
        )
    for name, known in {"unit": tuple(UNITS), "up": UPS}.items():
        if text(name) not in ("", *known):
            raise MotionFileError(
                f"{path}: {name} is '{printable(text(name)[:40])}'; expected one of"
                f" {', '.join(known)}"
            )
    return Recording(
        path,
        "npz",
        tuple(points),
        load,
        rate=positive(rate),
        unit=UNITS.get(text("unit")),
        up=next((up for up in UPS if up == text("up")), None),
    )
