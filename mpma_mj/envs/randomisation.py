"""Randomisation: options of an environment that are drawn for each episode."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.options import DRAWN_OPTIONS, EnvironmentOptions
from mpma_mj.envs.plants import PLANT_OPTIONS
from mpma_mj.utils.seeding import stream

__all__: list[str] = ["PlantValues", "Randomisation", "plants_of"]

Array = NDArray[np.float64]

PlantValues = dict[str, float]
"""Load, gain, damping and strength of a plant by the names of its options."""


class Randomisation:
    """Options that are ranges; each is drawn uniformly from the stream of its name.

    Attributes:
        names: Names of the K options that are drawn.
        of_plant: Whether an option of the plant is among them.
    """

    def __init__(self, options: EnvironmentOptions) -> None:
        """Find the options that are ranges."""
        self._ranges = options.ranges
        self._options = {name: getattr(options, name) for name in DRAWN_OPTIONS}
        self.names = tuple(self._ranges)
        self.of_plant = any(name in PLANT_OPTIONS for name in self.names)

    def draw(self, seed: int, episode: int) -> Array:
        """Draw the options of an episode, shape (K,); they depend on seed and episode alone."""
        ranges = self._ranges.items()
        return np.array([stream(seed, name, episode).uniform(*ends) for name, ends in ranges])

    def by_name(self, drawn: Array) -> dict[str, Array]:
        """Return drawn options, (K,) or (N, K), by name, each of shape () or (N,)."""
        return dict(zip(self.names, drawn.T.copy(), strict=True))

    def value(self, name: str, drawn: Array) -> float:
        """Return an option, drawn or not, in an episode with these drawn ones, shape (K,)."""
        return float((self._options | self.by_name(drawn))[name])

    def plant(self, drawn: Array) -> PlantValues | None:
        """Return the plant of an episode with these drawn options; None if none is of the plant."""
        if not self.of_plant:
            return None
        return {name: self.value(name, drawn) for name in PLANT_OPTIONS}


def plants_of(options: EnvironmentOptions) -> tuple[PlantValues, ...]:
    """Return each plant; where options are ranges, that of their highest and of their lowest."""
    owners = [{name: getattr(own, name) for name in PLANT_OPTIONS} for own in options.of_plants()]
    if not Randomisation(options).of_plant:
        return tuple(owners)
    return tuple(
        {name: value[end] if isinstance(value, tuple) else value for name, value in given.items()}
        for given in owners
        for end in (1, 0)
    )
