"""What agents remember of an episode."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["Memory"]

Array = NDArray[np.float64]

_FIRST = 256  # steps for which there is room at first


class Memory:
    """Arrays that grow by a row a step; the next episode is written over the last."""

    def __init__(self) -> None:
        """Begin with nothing remembered."""
        self._rows: dict[str, Array] = {}
        self._length = 0

    def __len__(self) -> int:
        """Return the number of steps."""
        return self._length

    def __getitem__(self, step: int) -> dict[str, Array]:
        """Return what was remembered of a step, by name; a negative one counts from the last."""
        row = range(self._length)[step]
        return {name: rows[row] for name, rows in self._rows.items()}

    def clear(self) -> None:
        """Forget the episode."""
        self._length = 0

    def append(self, step: Mapping[str, Array]) -> None:
        """Remember a step, arrays by name, of the same shapes as those of other steps."""
        for name, value in step.items():
            if name not in self._rows or self._rows[name].shape[1:] != value.shape:
                self._rows[name] = np.empty((_FIRST, *value.shape))
            if self._length == len(self._rows[name]):
                self._rows[name] = np.concatenate([self._rows[name]] * 2)
            self._rows[name][self._length] = value
        self._length += 1

    def episode(self) -> dict[str, Array]:
        """Return all steps, shape (T, ...) by name; views that the next episode overwrites."""
        return {name: rows[: self._length] for name, rows in self._rows.items()}
