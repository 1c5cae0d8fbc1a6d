"""Models of an environment's plants, and the one of them that is simulated."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

__all__: list[str] = ["CompiledPlants"]


class CompiledPlants:
    """One compiled model for each plant, and a live model that becomes any of them.

    The models have the same sizes and differ in numbers only, which are copied into the live model.
    MuJoCo's own `mj_setConst` would compute them instead, but it resets the pose.

    Attributes:
        models: Model of each plant.
        live: Model to simulate, at first of the first plant.
    """

    def __init__(self, models: Sequence[mujoco.MjModel]) -> None:
        """Find the numbers that differ.

        Args:
            models: Model of each plant.
        """
        self.models = tuple(models)
        self._plant = 0
        self.live = models[0] if len(models) == 1 else copy.copy(models[0])
        self._differing = _differing(self.live, self.models) + _differing(
            self.live.stat, [model.stat for model in models]
        )

    def use(self, plant: int) -> None:
        """Give the live model the numbers of a plant; states of simulations stay as they are.

        Args:
            plant: Index of the plant.
        """
        if plant == self._plant:
            return
        self._plant = plant
        for owner, name, values in self._differing:
            if isinstance(values[plant], np.ndarray):
                getattr(owner, name)[...] = values[plant]
            else:
                setattr(owner, name, values[plant])


def _differing(live: Any, each: Sequence[Any]) -> list[tuple[Any, str, list[Any]]]:
    """Return the numbers that are not equal in all: of the live one, by name, with all values."""
    found = []
    for name in dir(live):
        if name.startswith("_") or not isinstance(getattr(live, name), np.ndarray | float):
            continue
        values = [getattr(one, name) for one in each]
        if not all(np.array_equal(values[0], value, equal_nan=True) for value in values):
            found.append((live, name, values))
    return found
