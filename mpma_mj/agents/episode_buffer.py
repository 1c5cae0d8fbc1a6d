"""Buffer of an episode's signals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

__all__ = ["EpisodeBuffer"]

Array = NDArray[Any]  # of any precision

_FIRST = 256  # steps of the first allocation


class EpisodeBuffer:
    """Arrays that grow by a row a step; the next episode overwrites the last."""

    def __init__(self) -> None:
        """Begin empty."""
        self._rows: dict[str, Array] = {}
        self._lent: dict[str, Array] = {}
        self._most: dict[str, int] = {}
        self._length = 0

    def __len__(self) -> int:
        """Return the number of steps."""
        return self._length

    def last(self, name: str) -> Array:
        """Return an array of the last step."""
        return self._rows[name][self._row(name, self._length - 1)]

    def clear(self) -> None:
        """Remove all steps."""
        self._lent.clear()
        self._length = 0

    def reserve(
        self, name: str, shape: tuple[int, ...], kind: DTypeLike, most: int | None = None
    ) -> Array:
        """Return the place of an array of the next step, to be filled before `append`.

        Args:
            name: Its name, which the step that is appended may contain or not.
            shape: Its shape, the same for all steps.
            kind: Its precision.
            most: Largest number of steps to keep, all if not given; of a longer episode the last
                are kept, and `episode` leaves the array out.
        """
        row = self._length
        if most is None:
            self._most.pop(name, None)
        else:
            self._most[name] = most
            row %= most
        rows = self._rows.get(name)
        if rows is None or row in (0, len(rows)):
            rows = self._room(name, shape, kind)
        self._lent[name] = place = rows[row]
        return place

    def append(self, step: Mapping[str, Array]) -> None:
        """Append a step: arrays by name, of the same shapes in all steps."""
        lent, length, all_rows = self._lent, self._length, self._rows
        for name, value in step.items():
            if value is lent.get(name):
                continue
            rows = all_rows.get(name)
            if rows is None or length in (0, len(rows)):
                rows = self._room(name, value.shape, value.dtype)
            rows[length] = value
        lent.clear()
        self._length += 1

    def _room(self, name: str, shape: tuple[int, ...], kind: DTypeLike) -> Array:
        """Return the rows of a name, with one for the next step."""
        rows = self._rows.get(name)
        if rows is None or rows.shape[1:] != shape or rows.dtype != kind:
            rows = self._rows[name] = np.empty((max(_FIRST, self._length + 1), *shape), kind)
        elif self._row(name, self._length) == len(rows):
            longer = np.empty((2 * len(rows), *shape), kind)  # takes no memory until written
            longer[: len(rows)] = rows
            rows = self._rows[name] = longer
        return rows

    def episode(self) -> dict[str, Array]:
        """Return all steps, shape (T, ...) by name; views that the next episode overwrites."""
        return {
            name: rows[: self._length]
            for name, rows in self._rows.items()
            if self._length <= self._most.get(name, self._length)
        }

    def _row(self, name: str, step: int) -> int:
        """Return the row of a step."""
        return step % self._most[name] if name in self._most else step
