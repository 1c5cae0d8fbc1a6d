"""Timing in turn, so that a machine that becomes slower becomes slower for all; and the tables."""

from __future__ import annotations

import gc
import multiprocessing
import operator
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from typing import TypeVar
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from mpma_mj.utils.progress import show_range

__all__ = ["Case", "Report", "Sizes", "Target", "in_own_process", "in_turn", "ratio"]

Array = NDArray[np.float64]
Given, Returned = TypeVar("Given"), TypeVar("Returned")

_UNITS = (("s", 1.0), ("ms", 1e3), ("µs", 1e6))  # and how many make a second


@dataclass(frozen=True)
class Sizes:
    """How much is measured; scaling has sizes of its own."""

    rounds: int = 11
    """Rounds in which what is compared takes turns; half as many of programs and videos."""
    nodes: int = 50
    """Neurons of each reservoir."""
    runs: int = 20
    """Runs that are trained side by side."""

    @property
    def half(self) -> int:
        """Rounds of what takes seconds, at least one."""
        return (self.rounds + 1) // 2


@dataclass(frozen=True)
class Case:
    """What is timed: work that returns how many units of it there were, and what comes before."""

    run: Callable[[], int]
    prepare: Callable[[], object] = lambda: None


@dataclass(frozen=True, eq=False)
class Target:
    """What was measured in each round, shape (R,), and what the median should be at most.

    Or at least, where `at_least` says so. The unit is "" of a ratio.
    """

    values: Array
    wanted: float
    unit: str = ""
    at_least: bool = False


@dataclass(frozen=True, eq=False)
class Report:
    """Times of each round by what was timed, s, shape (R,); targets by name; lines of notes."""

    seconds: Mapping[str, Array] = field(default_factory=dict)
    targets: Mapping[str, Target] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def markdown(self) -> str:
        """Return a table of targets, one of times, and the notes."""
        parts = []
        if self.targets:
            head = ["| target | wanted | median | least to greatest |", "|---|---|---|---|"]
            parts.append("\n".join(head + [_target(*item) for item in self.targets.items()]))
        if self.seconds:
            head = ["| time | median | least to greatest |", "|---|---|---|"]
            parts.append("\n".join(head + [_time(*item) for item in self.seconds.items()]))
        return "\n\n".join([*parts, *self.notes])


def in_turn(title: str, cases: Mapping[str, Case], rounds: int) -> dict[str, Array]:
    """Time cases one after the other, round after round.

    Args:
        title: What is shown meanwhile.
        cases: What is timed, by name.
        rounds: Number of rounds, R; one before them warms up and does not count.

    Returns:
        Seconds per unit of work in each round, by name, shape (R,).
    """
    for case in cases.values():
        case.prepare()
        case.run()
    times: dict[str, list[float]] = {name: [] for name in cases}
    for _ in show_range(range(rounds), title):
        for name, case in cases.items():
            case.prepare()
            gc.collect()
            began = time.perf_counter()
            work = case.run()
            times[name].append((time.perf_counter() - began) / work)
    return {name: np.array(values) for name, values in times.items()}


def ratio(values: Array, others: Array, wanted: float, *, at_least: bool = False) -> Target:
    """Compare times of the same rounds, each of shape (R,), so that load affects both alike."""
    return Target(values / others, wanted, at_least=at_least)


def in_own_process(
    work: Callable[[Given], Returned], given: Given, variables: Mapping[str, str] = os.environ
) -> Returned:
    """Return what a module's function returns in a new process with environment variables."""
    spawn = multiprocessing.get_context("spawn")
    with mock.patch.dict(os.environ, variables, clear=True), ProcessPoolExecutor(1, spawn) as pool:
        return pool.submit(work, given).result()


def _time(name: str, seconds: Array) -> str:
    unit, scale = next((u for u in _UNITS if u[1] * np.median(seconds) >= 1.0), _UNITS[-1])
    median, least, greatest = (f"{scale * value:.3g}" for value in _spread(seconds))
    return f"| {name} | {median} {unit} | {least} to {greatest} {unit} |"


def _target(name: str, target: Target) -> str:
    unit = f" {target.unit}" if target.unit else ""
    sign, compare = ("≥", operator.lt) if target.at_least else ("≤", operator.gt)
    missed = " (missed)" if compare(np.median(target.values), target.wanted) else ""
    # Of a hundred and more, as of frames a second, what stands after the point is noise.
    median, least, greatest = (
        f"{value:.0f}" if value >= 100 else f"{value:.2f}" for value in _spread(target.values)
    )
    wanted = f"{sign} {target.wanted:g}{unit}"
    return f"| {name} | {wanted} | {median}{unit}{missed} | {least} to {greatest}{unit} |"


def _spread(values: Array) -> tuple[float, float, float]:
    return float(np.median(values)), float(values.min()), float(values.max())
