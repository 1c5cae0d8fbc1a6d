"""Features of a long episode, computed again instead of kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from mpma_mj.esn.precision import PRECISION, Features
from mpma_mj.esn.reservoir import ReservoirBank

__all__ = ["FeatureReplay", "blocks"]

_BLOCK = (
    4096  # steps of one sum, so that sums are equal for kept and for replayed features (choice)
)


class FeatureReplay:
    """Features z of an episode, shape (T, M, F), computed by the reservoirs once more.

    As noise depends on seed and episode alone, they are the same to the bit.

    Attributes:
        shape: (T, M, F).
    """

    def __init__(
        self,
        bank: ReservoirBank,
        noise: Callable[[], Sequence[np.random.Generator]],
        inputs: Features,
    ) -> None:
        """Keep the inputs and the source of the noise.

        Args:
            bank: Reservoirs of one run, with states that nothing else uses.
            noise: Returns the sources of the episode's noise, at its beginning, one for each group.
            inputs: Inputs v, shape (T, D) or (T, M, D).
        """
        self._bank, self._noise, self._inputs = bank, noise, inputs
        self.shape = (len(inputs), *bank.shape)

    def blocks(self) -> Iterator[tuple[slice, Features]]:
        """Yield steps and their features, (B, M, F), which the next block overwrites."""
        self._bank.reset(*([source] for source in self._noise()))
        steps = len(self._inputs)
        block = np.empty((min(_BLOCK, steps), *self._bank.shape), PRECISION)
        for start in range(0, steps, _BLOCK):
            rows = slice(start, min(start + _BLOCK, steps))
            for row, driving in enumerate(self._inputs[rows]):
                self._bank.step(driving, block[row])
            yield rows, block[: rows.stop - rows.start]


def blocks(features: Features | FeatureReplay) -> Iterator[tuple[slice, Features]]:
    """Yield steps of an episode and their features, shape (B, M, F), block by block."""
    if isinstance(features, FeatureReplay):
        yield from features.blocks()
        return
    for start in range(0, len(features), _BLOCK):
        rows = slice(start, start + _BLOCK)
        yield rows, features[rows]
