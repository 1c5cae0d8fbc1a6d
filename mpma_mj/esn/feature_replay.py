"""Features of a long episode, which are computed again rather than kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mpma_mj.esn.precision import PRECISION, Features
from mpma_mj.esn.reservoir import ReservoirBank

__all__ = ["FeatureReplay", "blocks"]

_BLOCK = 4096  # steps that are looked at together, so that sums are the same kept or not (choice)


class FeatureReplay:
    """Features z of an episode, shape (T, M, F), that reservoirs go through once more.

    Since noise depends on the episode alone, they are what they were to the bit.

    Attributes:
        shape: (T, M, F).
    """

    def __init__(
        self,
        bank: ReservoirBank,
        noise: Callable[[], np.random.Generator],
        inputs: Features,
        count: int | None = None,
    ) -> None:
        """Take what is needed to go through it.

        Args:
            bank: Reservoirs of one run, whose states are nobody else's.
            noise: Returns the source of the episode's noise, from its beginning.
            inputs: Inputs v, shape (T, D) or (T, M, D).
            count: How many of the first reservoirs count; all if not given.
        """
        self._bank, self._noise, self._inputs = bank, noise, inputs
        modules, features = bank.shape
        self.shape = (len(inputs), modules if count is None else count, features)

    def first_modules(self, count: int) -> FeatureReplay:
        """Return those of the first reservoirs, shape (T, M', F)."""
        return FeatureReplay(self._bank, self._noise, self._inputs, count)

    def blocks(self) -> Iterator[tuple[slice, Features]]:
        """Yield steps, and their features; an array that the next block overwrites."""
        self._bank.reset([self._noise()])
        steps, count, _ = self.shape
        block = np.empty((min(_BLOCK, steps), *self._bank.shape), PRECISION)
        for start in range(0, steps, _BLOCK):
            rows = slice(start, min(start + _BLOCK, steps))
            for row, driving in enumerate(self._inputs[rows]):
                self._bank.step(driving, block[row])
            yield rows, block[: rows.stop - rows.start, :count]


def blocks(features: Features | FeatureReplay) -> Iterator[tuple[slice, Features]]:
    """Yield steps of an episode, and their features, shape (B, M, F), block by block."""
    if isinstance(features, FeatureReplay):
        yield from features.blocks()
        return
    for start in range(0, len(features), _BLOCK):
        rows = slice(start, start + _BLOCK)
        yield rows, features[rows]
