"""Schedule of plants: which one is on at each step of an episode."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.switch_schedule import SwitchSchedule
from mpma_mj.utils.seeding import stream

__all__: list[str] = ["PlantSchedule"]


class PlantSchedule:
    """Plants by the options `plants`, `switch_every` and `epochs_per_plant`.

    Without `switch_every` an episode has one plant; the plants take turns. With it the first is
    drawn, and after a number of steps that is drawn from the range another one follows, any with
    equal probability.
    """

    def __init__(self, options: EnvironmentOptions, rate: float) -> None:
        """Take the options.

        Args:
            options: Options of the environment.
            rate: Control steps per second, Hz.

        Raises:
            BadOptionError: No whole number of control steps is in the range `switch_every`.
        """
        self._number = 0 if options.plants is None else len(options.plants)
        self._epochs = options.epochs_per_plant
        self._switches = SwitchSchedule.if_given("switch_every", options.switch_every, rate)

    def draw(self, seed: int, episode: int, start: int, steps: int) -> NDArray[np.intp] | None:
        """Return the index of the plant that is on at each step; None without plants.

        Args:
            seed: Seed of everything random.
            episode: Number of the episode, from 0.
            start: Step at which the episode starts.
            steps: Number of steps T of the demonstration.

        Returns:
            Indices, shape (T,), the same before the start as at it.
        """
        if not self._number:
            return None
        if self._switches is None:
            return np.full(steps, episode // self._epochs % self._number, np.intp)
        return self._switches.draw(stream(seed, "plants", episode), self._number, start, steps)
