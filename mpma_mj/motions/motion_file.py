"""Our own file of a movement: a NumPy archive (.npz) of named arrays; see docs/formats.md."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.cleaning.filtering import anti_alias, resample
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.readers.npz import is_archive, read_archive
from mpma_mj.utils import atomic_files

__all__ = ["at_rate", "read", "write"]

FORMAT = 3
"""Version of the format of motion files, apart from that of run folders."""


def write(path: Path, motion: Motion) -> None:
    """Write a movement.

    Raises:
        RunFolderError: The file cannot be written.
    """
    named = {field.name: getattr(motion, field.name) for field in dataclasses.fields(motion)}
    arrays: dict[str, Any] = {name: np.asarray(value) for name, value in named.items()}
    arrays["format"] = np.array(FORMAT)
    with atomic_files.atomic_write(path) as temporary:
        np.savez(temporary, **arrays)


def read(path: Path) -> Motion | None:
    """Read a movement, of which only `posture` and `rate` have to be there.

    Returns:
        The movement; None if the file is something else, such as points.

    Raises:
        MotionFileError: The file is damaged, or what it holds does not fit together.
    """
    with path.open("rb") as file:
        if not is_archive(file.read(4)):
            return None
    arrays = read_archive(path)
    if "posture" not in arrays:
        return None
    if str(arrays.get("format", FORMAT)) != str(FORMAT):
        raise MotionFileError(f"{path}: of another version of this program; make it anew")
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
        )
    except KeyError as error:
        raise MotionFileError(f"{path}: lacks {error.args[0]}; add it as an array") from None
    except (ValueError, TypeError, IndexError):
        raise MotionFileError(
            f"{path}: expected posture (T, 12), context (T, C), labels (C,) and rate as numbers;"
            f" it has {', '.join(f'{name} {a.dtype}{a.shape}' for name, a in arrays.items())}"
        ) from None


def at_rate(motion: Motion, rate: float, tempo: float) -> Motion:
    """Return a movement at another rate and tempo.

    Args:
        motion: The movement.
        rate: Postures per second that are wanted, Hz.
        tempo: Speed relative to the motion as it is.
    """
    if rate == motion.rate and tempo == 1.0:
        return motion
    own_rate = motion.rate * tempo
    vectors = resample(anti_alias(motion.posture, own_rate, rate), own_rate, rate).reshape(-1, 4, 3)
    vectors = vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
    nearest = np.round(np.arange(len(vectors)) * own_rate / rate).astype(int)
    return dataclasses.replace(
        motion,
        posture=vectors.reshape(-1, 12),
        context=motion.context[np.minimum(nearest, len(motion) - 1)],
        rate=rate,
        tempo=motion.tempo * tempo,
    )
