"""The motion that is imitated: postures of two arms with their context, and its `.npz` file."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths
from mpma_mj.errors import MotionFileError
from mpma_mj.motions.readers.npz import is_archive, read_archive
from mpma_mj.options import TWO_ARM
from mpma_mj.utils.atomic_files import atomic_write
from mpma_mj.utils.text import printable

__all__ = ["Motion", "load_motion", "motion_arrays", "motion_of_arrays", "save_motion"]

Array = NDArray[np.float64]

FORMAT = 3
"""Version of the format of motion files, apart from that of run folders."""

_RATES = (0.1, 100_000.0)  # Hz: beyond, resampling fails or fills the memory (choice)
_LATEST = 1e9  # s (choice)


@dataclass(frozen=True, eq=False, repr=False)
class Motion:
    """A demonstrated motion; name, source and labels are made printable.

    Attributes:
        posture: Postures, shape (T, 12): four unit vectors each, see `kinematics`.
        context: Context signal, shape (T, C), in [0, 1].
        labels: Names of the C entries of the context, such as letters.
        rate: Postures per second, Hz.
        name: Short name, used for folders and titles.
        source: Where the motion comes from, one sentence.
        tempo: Speed relative to the original.
        start: Where it begins in the recording, s.
        feasible_angles: Joint angles of the closest motion that arms can follow, shape (T, 8), rad;
            None for a motion that needs no change. See `feasible`.
        angles_of: Name of the arms whose joint angles they are; see `ArmKinematics`.

    Raises:
        MotionFileError: Shapes do not fit, a value is not finite, a vector has not length 1,
            there are fewer than two postures, no label, or a rate of no recording.
    """

    posture: Array
    context: Array
    labels: tuple[str, ...]
    rate: float
    name: str
    source: str
    tempo: float = 1.0
    start: float = 0.0
    feasible_angles: Array | None = None
    angles_of: str = TWO_ARM

    def __repr__(self) -> str:
        """Return name and length in one line, without the arrays."""
        return f"<Motion {self.name}: {len(self.posture)} postures at {self.rate:g} Hz>"

    def __post_init__(self) -> None:
        """Check what every user of a motion relies on."""
        for field in ("name", "source"):
            object.__setattr__(self, field, printable(getattr(self, field)))
        object.__setattr__(self, "labels", tuple(map(printable, self.labels)))
        if self.feasible_angles is None:  # then joint angles are those of a person
            object.__setattr__(self, "angles_of", TWO_ARM)
        frames = len(self.posture)
        if not _RATES[0] <= self.rate <= _RATES[1]:
            hertz = f"{_RATES[0]:g} to {_RATES[1]:,.0f} Hz"
            raise MotionFileError(f"{self.name}: rate is {self.rate:g}; expected {hertz}")
        if not abs(self.start) <= _LATEST:
            raise MotionFileError(f"{self.name}: start is {self.start:g}; expected seconds")
        if not self.labels:
            raise MotionFileError(f"{self.name}: has no label; a context needs at least one")
        if frames < 2:
            raise MotionFileError(
                f"{self.name}: has {frames} posture(s) at {self.rate:g} Hz; a motion needs at"
                " least two; record for longer"
            )
        expected = {"posture": (frames, 12), "context": (frames, len(self.labels))}
        if self.feasible_angles is not None:
            expected["feasible_angles"] = (frames, 8)
        for field, shape in expected.items():
            value = np.array(getattr(self, field), np.float64)  # a copy, which stays as it is
            value.setflags(write=False)
            object.__setattr__(self, field, value)
            if value.shape != shape:
                raise MotionFileError(
                    f"{self.name}: {field} has shape {value.shape}, expected {shape}"
                )
            if not np.isfinite(value).all():
                raise MotionFileError(f"{self.name}: {field} contains a value that is not finite")
        if self.context.min() < 0.0 or self.context.max() > 1.0:
            raise MotionFileError(f"{self.name}: context contains a value outside [0, 1]")
        lengths = np.linalg.norm(self.posture.reshape(frames, 4, 3), axis=-1)
        if not np.allclose(lengths, 1.0, atol=1e-6):
            raise MotionFileError(f"{self.name}: posture contains vectors whose length is not 1")

    def __len__(self) -> int:
        """Return the number of postures."""
        return len(self.posture)

    @functools.cached_property
    def joint_angles(self) -> Array:
        """Joint angles, without jumps between branches, (T, 8), rad.

        Those of a feasible motion; else those that hold the postures, see
        `joint_paths.held_angles`.
        """
        if self.feasible_angles is not None:
            return self.feasible_angles
        angles = joint_paths.held_angles(self.posture)
        angles.setflags(write=False)
        return angles

    def time(self, step: int) -> float:
        """Return the time of a step in the recording, s."""
        return self.start + step / self.rate * self.tempo

    @property
    def duration(self) -> float:
        """Duration, s."""
        return len(self) / self.rate


def save_motion(path: Path, motion: Motion) -> None:
    """Write a motion.

    Raises:
        RunFolderError: The file cannot be written.
    """
    with atomic_write(path) as temporary:
        np.savez(temporary, **motion_arrays(motion))


def motion_arrays(motion: Motion) -> dict[str, Any]:
    """Return what a file holds of a motion, arrays by name."""
    named = {field.name: getattr(motion, field.name) for field in dataclasses.fields(motion)}
    arrays: dict[str, Any] = {n: np.asarray(v) for n, v in named.items() if v is not None}
    return arrays | {"format": np.array(FORMAT)}


def load_motion(path: Path) -> Motion | None:
    """Read a motion; only `posture` and `rate` are required.

    Returns:
        The motion; None if the file contains something else, such as points.

    Raises:
        MotionFileError: The file is damaged, or its arrays do not fit together.
    """
    with path.open("rb") as file:
        if not is_archive(file.read(4)):
            return None
    arrays = read_archive(path)
    return motion_of_arrays(arrays, path) if "posture" in arrays else None


def motion_of_arrays(arrays: Mapping[str, NDArray[Any]], path: Path) -> Motion:
    """Return the motion that a file holds.

    Raises:
        MotionFileError: As of `load_motion`.
    """
    if str(arrays.get("format", FORMAT)) != str(FORMAT):
        raise MotionFileError(
            f"{path}: written by another version of this program; create it again"
        )
    try:
        posture = np.asarray(arrays["posture"], np.float64)
        context = np.asarray(arrays.get("context", np.ones((len(posture), 1))), np.float64)
        tempo = float(arrays.get("tempo", 1.0))
        if not 0.0 < tempo < np.inf:
            raise MotionFileError(f"{path}: tempo is {tempo:g}; expected a number above 0")
        default = [str(i + 1) for i in range(context.shape[1])]
        return Motion(
            posture,
            context,
            tuple(map(str, arrays.get("labels", default))),
            float(arrays["rate"]),
            str(arrays.get("name", path.stem)),
            str(arrays.get("source", path.name)),
            tempo,
            float(arrays.get("start", 0.0)),
            arrays.get("feasible_angles"),
            str(arrays.get("angles_of", TWO_ARM)),
        )
    except KeyError as error:
        raise MotionFileError(f"{path}: lacks {error.args[0]}; add it as an array") from None
    except (ValueError, TypeError, IndexError):
        raise MotionFileError(
            f"{path}: expected posture (T, 12), context (T, C), labels (C,) and rate as numbers;"
            f" it has {', '.join(f'{name} {a.dtype}{a.shape}' for name, a in arrays.items())}"
        ) from None
