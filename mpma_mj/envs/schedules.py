"""Schedules of an episode: which plant is on at each step, and how late the action is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.seeding import stream

__all__: list[str] = ["LatencySchedule", "PlantSchedule", "SwitchSchedule"]

_ROUNDING = 1e-6  # steps


class SwitchSchedule:
    """Switches among a number of values, after times that are drawn uniformly from a range.

    The first value is drawn uniformly; at each switch another one follows, any with equal
    probability.
    """

    def __init__(self, option: str, seconds: tuple[float, float], rate: float) -> None:
        """Take the range.

        Args:
            option: Name of the option that is the range.
            seconds: Lowest and highest time between two switches, s.
            rate: Control steps per second, Hz.

        Raises:
            BadOptionError: No whole number of control steps is in the range.
        """
        low, high = (rate * time for time in seconds)
        self._low, self._high = math.ceil(low - _ROUNDING), math.floor(high + _ROUNDING)
        if low < 1.0 - _ROUNDING or self._low > self._high:
            raise BadOptionError(
                option=option,
                value=seconds,
                expected=f"a range from {1.0 / rate:g} s up, one control step, with a whole"
                " number of control steps in it",
            )

    @classmethod
    def if_given(
        cls, option: str, seconds: tuple[float, float] | None, rate: float
    ) -> SwitchSchedule | None:
        """Return the schedule of an option; None where the option is not given."""
        return None if seconds is None else cls(option, seconds, rate)

    def draw(
        self, rng: np.random.Generator, number: int, start: int, steps: int
    ) -> NDArray[np.intp]:
        """Return the index of the value at each step.

        Args:
            rng: Generator.
            number: Number of values, at least 2.
            start: Step at which the episode starts.
            steps: Number of steps T.

        Returns:
            Indices, shape (T,), the same before the start as at it.
        """
        switches = -(-steps // self._low)
        ends = start + rng.integers(self._low, self._high, switches, endpoint=True).cumsum()
        to_next = rng.integers(1, number, switches)
        values = (rng.integers(number) + np.append(0, to_next.cumsum())) % number
        return values[np.searchsorted(ends, np.arange(steps), side="right")]


class PlantSchedule:
    """Plants by the options `plants`, `switch_every` and `epochs_per_plant`.

    Without `switch_every` an episode has one plant; the plants take turns. With it the first is
    drawn, and after a number of steps that is drawn from the range another one follows, any with
    equal probability.
    """

    def __init__(self, options: EnvironmentOptions, rate: float) -> None:
        """Take options and control steps per second, Hz; errors as of `SwitchSchedule`."""
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


class LatencySchedule:
    """Latencies by the options `latency`, where it is a range, and `latency_every`.

    Without `latency_every` an episode has one latency, drawn uniformly from the range. With it
    the first is drawn like that, and after a number of steps that is drawn too another one of the
    range follows, any with equal probability.
    """

    def __init__(self, options: EnvironmentOptions, rate: float) -> None:
        """Take options and control steps per second, Hz; errors as of `SwitchSchedule`."""
        self._range = None if isinstance(options.latency, int) else options.latency
        self._switches = SwitchSchedule.if_given("latency_every", options.latency_every, rate)

    def draw(self, seed: int, episode: int, start: int, steps: int) -> NDArray[np.intp] | None:
        """Return the latency at each step, shape (T,), control steps; None where it is one number.

        Arguments are those of `PlantSchedule.draw`.
        """
        if self._range is None:
            return None
        low, high = self._range
        rng = stream(seed, "latency", episode)
        if self._switches is None:
            return np.full(steps, rng.integers(low, high, endpoint=True), np.intp)
        return low + self._switches.draw(rng, high - low + 1, start, steps)
