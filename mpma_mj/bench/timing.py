"""Timing in turn, so that a machine that becomes slower becomes slower for all."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Bound",
    "Case",
    "Progress",
    "Ratio",
    "Spread",
    "Target",
    "bound",
    "in_turn",
    "ratio",
    "spread",
]

Array = NDArray[np.float64]
Progress = Callable[[range, str], Iterable[int]]
"""Shows how far a range of rounds is, under a title."""


@dataclass(frozen=True)
class Case:
    """What is timed.

    Attributes:
        run: Does the work and returns how many units of it there were.
        prepare: Comes before, and is not timed.
    """

    run: Callable[[], int]
    prepare: Callable[[], object] = lambda: None


@dataclass(frozen=True)
class Spread:
    """Median, least and greatest of repeated measurements."""

    median: float
    least: float
    greatest: float


@dataclass(frozen=True)
class Target:
    """What was reached of what is wanted.

    Attributes:
        spread: What was measured, over the rounds.
        wanted: What it should be at most, or at least where `at_least` says so.
        at_least: Which of the two.
    """

    spread: Spread
    wanted: float
    at_least: bool = False

    @property
    def reached(self) -> bool:
        """Whether the median is as wanted."""
        median = self.spread.median
        return median >= self.wanted if self.at_least else median <= self.wanted


@dataclass(frozen=True)
class Ratio(Target):
    """How one time compares with another, round by round."""


@dataclass(frozen=True)
class Bound(Target):
    """What is wanted of a quantity itself, on whatever machine this is.

    Attributes:
        unit: Its unit; "" for a number without one.
    """

    unit: str = "s"


def in_turn(cases: Mapping[str, Case], rounds: Iterable[int]) -> dict[str, Array]:
    """Time cases one after the other, round after round.

    Args:
        cases: What is timed, by name.
        rounds: Numbers of the rounds; one before them warms up and does not count.

    Returns:
        Seconds per unit of work in each round, by name, shape (R,).
    """
    for case in cases.values():
        case.prepare()
        case.run()
    times: dict[str, list[float]] = {name: [] for name in cases}
    for _ in rounds:
        for name, case in cases.items():
            case.prepare()
            gc.collect()
            began = time.perf_counter()
            work = case.run()
            times[name].append((time.perf_counter() - began) / work)
    return {name: np.array(values) for name, values in times.items()}


def spread(values: Array) -> Spread:
    """Return median, least and greatest of values, shape (R,)."""
    return Spread(float(np.median(values)), float(values.min()), float(values.max()))


def ratio(values: Array, others: Array, wanted: float, *, at_least: bool = False) -> Ratio:
    """Compare times of the same rounds, each of shape (R,)."""
    return Ratio(spread(values / others), wanted, at_least)


def bound(values: Array, wanted: float, unit: str = "s", *, at_least: bool = False) -> Bound:
    """Hold measurements, shape (R,), against what is wanted of them."""
    return Bound(spread(values), wanted, at_least, unit)
