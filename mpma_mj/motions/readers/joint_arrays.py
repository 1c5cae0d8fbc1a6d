"""Reader for joints in one array of shape (T, J, 3), by itself (.npy) or in an archive.

The joints have no names: those of a known number are named in the order of the skeleton that
they fit (`joint_orders.toml`); others are called by their number, from 0, for a mapping.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tokenize import TokenError  # of a header that NumPy takes for Python 2
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.joint_orders import find_order, known_orders
from mpma_mj.motions.readers.missing_samples import mark_missing
from mpma_mj.motions.readers.recording import Recording, Tracks, Up

__all__ = ["FEWEST", "NAME_LISTS", "find_joints", "is_npy", "read_joints", "read_npy"]

Array = NDArray[np.float64]

FEWEST = 6
"""Joints that two arms have."""
NAME_LISTS = (
    *("names", "joint_names", "joints_names", "keypoint_names", "landmark_names", "marker_names"),
    *("body_names", "labels"),
)
"""What files call the list of the joints' names, in lower case."""

_LARGEST = 1 << 30  # bytes
_HUMANML = 22  # joints; HumanML3D's are at 20 Hz, y up
_HUMANML_RATE = 20.0
# Numbers a frame of arrays that are no joints, and the way out.
_FEATURES = {
    263: ("HumanML3D's features", "give the joints instead, (T, 22, 3) in its folder new_joints"),
    251: ("KIT-ML's features", "give the joints instead, (T, 21, 3) in its folder new_joints"),
    322: ("Motion-X's parameters of SMPL-X", "save array[:, :66] as poses in an npz"),
}
# Arrays that have the shape of joints and are no places.
_NO_PLACES = re.compile(r"vel|acc|rot|quat|orient|vert|normal|force|conf", re.IGNORECASE)
_PICTURE = 10.0  # x and y beyond which a third number in 0-1 is a confidence, not a depth


@dataclass(frozen=True)
class Joints:
    """Joints of one person.

    Attributes:
        array: Where they are, shape (T, J, 3).
        names: Their names, if the file has some.
        title: What the file calls the array; "" for one without a name.
    """

    array: Array
    names: tuple[str, ...] = ()
    title: str = ""


def is_npy(head: bytes) -> bool:
    """Return whether the first bytes are those of a NumPy array."""
    return head.startswith(b"\x93NUMPY")


def read_npy(path: Path, report: ImportReport) -> Recording:
    """Read an array of joints.

    Raises:
        MotionFileError: It is damaged, or has another shape.
    """
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError, OSError, MemoryError, SyntaxError, TokenError) as error:
        if "Python objects" in str(error):
            raise MotionFileError(
                f"{path}: holds Python objects, which can run code and are never opened; save the"
                " joints as an array of numbers of shape (T, J, 3)"
            ) from None
        raise MotionFileError(f"{path}: is a damaged NumPy array; save it again") from None
    if array.nbytes > _LARGEST:
        raise MotionFileError(f"{path}: holds {array.nbytes / 2**30:.1f} GB; keep one recording")
    return read_joints(path, Joints(_checked(path, "the array", array)), report)


def find_joints(path: Path, arrays: Mapping[str, NDArray[Any]]) -> Joints | None:
    """Return the joints in an archive, if one of its arrays holds some.

    Raises:
        MotionFileError: Several do, or it holds something else in their place.
    """
    found = {
        name: array
        for name, array in arrays.items()
        if array.dtype.kind in "fiu"
        and array.ndim > 2
        and array.shape[-1] in (3, 4)
        and not _NO_PLACES.search(name)
    }
    if len(found) > 1:
        listed = ", ".join(f"{name} {array.shape}" for name, array in found.items())
        raise MotionFileError(f"{path}: has several arrays of joints, {listed}; keep one of them")
    for title, array in found.items():
        joints = _checked(path, title, array)
        named = next((arrays[n] for n in arrays if n.lower() in NAME_LISTS), np.empty(0))
        names = tuple(str(name) for name in named.reshape(-1)) if named.dtype.kind == "U" else ()
        return Joints(joints, names if len(names) == joints.shape[1] else (), title)
    return None


def read_joints(
    path: Path,
    joints: Joints,
    report: ImportReport,
    *,
    format_name: str = "npy",
    rate: float | None = None,
    unit: float | None = None,
    up: Up | None = None,
) -> Recording:
    """Name joints by the skeleton that they are of.

    Args:
        path: The file.
        joints: Its joints.
        report: Gets which skeleton is found.
        format_name: Name of the file's format.
        rate: Declared frames per second, Hz.
        unit: Declared length of the unit, m.
        up: Declared axis that points up.
    """
    array = joints.array
    count = array.shape[1]
    names = joints.names or _names(array, report)
    if rate is None and count == _HUMANML and names[0] == "pelvis" and _is_y_up(array):
        rate = _HUMANML_RATE
        report.warn(
            f"{_HUMANML} joints, y up, are taken for HumanML3D's, which have {rate:g} Hz",
            remedy="{rate_in} overrides it",
        )
    number = {name: i for i, name in reversed([*enumerate(names)])}

    def load(requested: Sequence[str]) -> Tracks:
        tracks = {name: array[:, number[name]].copy() for name in requested}
        mark_missing(tracks, report)
        return tracks

    return Recording(path, format_name, names, load, rate=rate, unit=unit, up=up)


def _names(joints: Array, report: ImportReport) -> tuple[str, ...]:
    """Return names of joints, shape (T, J, 3), by their order, or their numbers."""
    count = joints.shape[1]
    seen = joints.any(axis=2, keepdims=True)
    order = find_order(np.where(seen, joints, np.nan))
    if order is not None:
        report.note(f"its {count} joints are in the order of {order.name}")
        return order.names(count)
    known = " or ".join(order.name for order in known_orders(count))
    report.warn(
        f"its {count} joints have no names"
        + (f", and arms and trunk in the order of {known} are not those of a body" * bool(known)),
        remedy="name them by their number, from 0, with {map}, such as {map=left_wrist=20,…}",
    )
    return tuple(map(str, range(count)))


def _is_y_up(joints: Array) -> bool:
    """Return whether the necks of SMPL's joints, shape (T, J, 3), are above the pelvis along y."""
    trunk = np.nanmedian(joints[:, 12] - joints[:, 0], axis=0)
    return bool(trunk[1] > 2.0 * np.abs(trunk[[0, 2]]).max())


def _checked(path: Path, title: str, array: NDArray[Any]) -> Array:
    """Return joints, shape (T, J, 3), of an array, or refuse it by its shape."""
    shape = array.shape
    where = f"{path}: {title} has shape {shape}"
    if array.dtype.kind not in "fiu":
        raise MotionFileError(f"{path}: {title} holds {array.dtype}; expected numbers (T, J, 3)")
    if array.ndim == 2 and shape[1] in _FEATURES:
        what, remedy = _FEATURES[shape[1]]
        raise MotionFileError(f"{where}: those are {what}; {remedy}")
    if array.ndim == 2 and shape[1] % 3 == 0 and known_orders(shape[1] // 3):
        rows = np.asarray(array, np.float64).reshape(len(array), -1, 3)
        if find_order(rows) is not None:
            return rows
    if array.ndim == 4 and shape[-1] in (3, 4) and 1 in shape[:2]:
        array = array[0] if shape[0] == 1 else array[:, 0]
    elif array.ndim == 4 and shape[-2:] == (3, 3):
        raise MotionFileError(f"{where}: those are rotations; save the places of joints, (T, J, 3)")
    elif array.ndim == 4 and shape[-1] == 3:
        raise MotionFileError(
            f"{where}: it shows {min(shape[:2])} people; save one of them, (T, J, 3)"
        )
    if array.ndim != 3 or array.shape[-1] not in (3, 4) or array.shape[1] < FEWEST:
        picture = "; two coordinates are those of a picture" * (shape[-1:] == (2,))
        rotations = "; six numbers are rotations, not places" * (shape[-1:] == (6,))
        raise MotionFileError(
            f"{where}; expected joints of shape (T, J, 3): frames, joints, and x, y, z"
            f"{picture}{rotations}"
        )
    if array.shape[2] == 4 and not _are_shares(array[..., 3]):
        raise MotionFileError(f"{where}: four numbers a joint are no place; save x, y, z alone")
    joints = np.array(array[..., :3], np.float64)
    if _are_shares(joints[..., 2]) and np.nanmax(np.abs(joints[..., :2])) > _PICTURE:
        raise MotionFileError(
            f"{path}: {title} holds places in a picture with a confidence in 0-1, not x, y, z; use"
            " an estimator of three-dimensional joints"
        )
    return joints


def _are_shares(values: NDArray[Any]) -> bool:
    """Return whether all numbers are in 0-1, as confidences are."""
    seen = values[np.isfinite(values)]
    return bool(seen.size and seen.min() >= 0.0 and seen.max() <= 1.0)
