"""What is imitated: a movement of two arms with its context."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.errors import MotionFileError
from mpma_mj.utils.text import printable

__all__ = ["Motion"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Motion:
    """A demonstrated movement.

    Its name, source and labels are kept as text that can be shown: see `names.printable`.

    Attributes:
        posture: Postures in the order of time, shape (T, 12): four unit vectors, see `arm`.
        context: Context signal, "the music", shape (T, C), in [0, 1].
        labels: Names of the context's C entries, such as the letters that are danced.
        rate: Postures per second, Hz.
        name: Short name, used for folders and titles.
        source: Where the movement comes from, one sentence.
        tempo: Speed relative to the original.

    Raises:
        MotionFileError: Shapes do not fit, a value is not finite, a vector has not length 1,
            there are fewer than two postures, no label, or no rate above 0.
    """

    posture: Array
    context: Array
    labels: tuple[str, ...]
    rate: float
    name: str
    source: str
    tempo: float = 1.0

    def __repr__(self) -> str:
        """Return name and length in one line, without the arrays."""
        return f"<Motion {self.name}: {len(self.posture)} postures at {self.rate:g} Hz>"

    def __post_init__(self) -> None:
        """Check what every user of a motion relies on."""
        for field in ("name", "source"):
            object.__setattr__(self, field, printable(getattr(self, field)))
        object.__setattr__(self, "labels", tuple(map(printable, self.labels)))
        frames = len(self.posture)
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise MotionFileError(f"{self.name}: rate is {self.rate:g}; expected Hz above 0")
        if not self.labels:
            raise MotionFileError(f"{self.name}: has no label; a context needs at least one")
        if frames < 2:
            raise MotionFileError(
                f"{self.name}: has {frames} posture(s) at {self.rate:g} Hz; a movement needs at"
                " least two, so record for longer"
            )
        expected = {"posture": (frames, 12), "context": (frames, len(self.labels))}
        for field, shape in expected.items():
            value = np.array(getattr(self, field), np.float64)  # a copy, which stays as it is
            value.setflags(write=False)
            object.__setattr__(self, field, value)
            if value.shape != shape:
                raise MotionFileError(
                    f"{self.name}: {field} has shape {value.shape}, expected {shape}"
                )
            if not np.isfinite(value).all():
                raise MotionFileError(f"{self.name}: {field} holds a value that is not finite")
        if self.context.min() < 0.0 or self.context.max() > 1.0:
            raise MotionFileError(f"{self.name}: context holds a value outside [0, 1]")
        lengths = np.linalg.norm(self.posture.reshape(frames, 4, 3), axis=-1)
        if not np.allclose(lengths, 1.0, atol=1e-6):
            raise MotionFileError(f"{self.name}: posture holds vectors that have not length 1")

    def __len__(self) -> int:
        """Return the number of postures."""
        return len(self.posture)

    @functools.cached_property
    def joint_angles(self) -> Array:
        """Joint angles that hold the postures, without jumps between branches, (T, 8), rad."""
        angles = kinematics.continuous_angles(self.posture)
        angles.setflags(write=False)
        return angles

    @property
    def duration(self) -> float:
        """Duration, s."""
        return len(self) / self.rate
