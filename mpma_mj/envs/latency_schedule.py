"""Schedule of latencies: how late the action of each step of an episode is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.switch_schedule import SwitchSchedule
from mpma_mj.utils.seeding import stream

__all__: list[str] = ["LatencySchedule"]


class LatencySchedule:
    """Latencies by the options `latency`, where it is a range, and `latency_every`.

    Without `latency_every` an episode has one latency, drawn uniformly from the range. With it
    the first is drawn like that, and after a number of steps that is drawn too another one of the
    range follows, any with equal probability.
    """

    def __init__(self, options: EnvironmentOptions, rate: float) -> None:
        """Take the options.

        Args:
            options: Options of the environment.
            rate: Control steps per second, Hz.

        Raises:
            BadOptionError: No whole number of control steps is in the range `latency_every`.
        """
        self._range = None if isinstance(options.latency, int) else options.latency
        self._switches = SwitchSchedule.if_given("latency_every", options.latency_every, rate)

    def draw(self, seed: int, episode: int, start: int, steps: int) -> NDArray[np.intp] | None:
        """Return the latency in force at each step; None where the option is one number.

        Args:
            seed: Seed of everything random.
            episode: Number of the episode, from 0.
            start: Step at which the episode starts.
            steps: Number of steps T of the demonstration.

        Returns:
            Latencies, shape (T,), control steps, the same before the start as at it.
        """
        if self._range is None:
            return None
        low, high = self._range
        rng = stream(seed, "latency", episode)
        if self._switches is None:
            return np.full(steps, rng.integers(low, high, endpoint=True), np.intp)
        return low + self._switches.draw(rng, high - low + 1, start, steps)
