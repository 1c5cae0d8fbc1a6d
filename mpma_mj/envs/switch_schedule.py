"""Schedule of switches: when a value changes within an episode, and to which other one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError

__all__: list[str] = ["SwitchSchedule"]

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
