"""How time and memory of training grow with the length of the dance and the size of what learns."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from mpma_mj.bench.child import python
from mpma_mj.bench.report import Report
from mpma_mj.bench.timing import Progress, bound, ratio

__all__ = ["AXES", "Axis", "Measured", "Point", "Scaling", "exponent", "measure"]

Axis: TypeAlias = Literal["steps", "modules", "nodes", "runs"]

AXES: dict[Axis, tuple[int, ...]] = {
    "steps": (1_000, 3_000, 10_000, 30_000, 100_000),
    "modules": (1, 2, 4, 8, 16, 32, 64),
    "nodes": (50, 100, 200, 400, 800, 1600),
    "runs": (1, 2, 4, 8, 16, 32, 64),
}
"""Amounts of what is varied; the rest is as in a run of YMCA by default."""

_SHOULD_BE_LINEAR: tuple[Axis, ...] = ("steps", "modules")
_LINEAR = 1.1  # most that an exponent may be of what is linear
_LONGEST = 1.0  # GB that the longest dance may take


@dataclass(frozen=True)
class Point:
    """What is trained.

    Attributes:
        axis: What is varied.
        steps: Steps of an epoch.
        modules: Number of modules.
        nodes: Neurons of each reservoir.
        runs: Runs side by side.
    """

    axis: Axis
    steps: int = 227
    modules: int = 4
    nodes: int = 200
    runs: int = 1

    @property
    def amount(self) -> int:
        """How much of it there is."""
        return int(getattr(self, self.axis))


@dataclass(frozen=True)
class Measured:
    """What a training took.

    Attributes:
        point: What was trained.
        seconds: Time of each epoch, s.
        memory: Most memory that the process had, bytes.
        inherent: What motion and trace of an epoch hold of it, bytes; of many runs the motion only.
    """

    point: Point
    seconds: tuple[float, ...]
    memory: int
    inherent: int

    @property
    def epoch(self) -> float:
        """Time of an epoch, the median, s."""
        return float(np.median(self.seconds))


@dataclass(frozen=True)
class Scaling:
    """All points.

    Attributes:
        measured: What each took.
    """

    measured: tuple[Measured, ...]

    def along(self, axis: Axis) -> list[Measured]:
        """Return the points along an axis, the least amount first."""
        there = [one for one in self.measured if one.point.axis == axis]
        return sorted(there, key=lambda one: one.point.amount)

    def exponents(self, axis: Axis) -> tuple[float, float]:
        """Return the fitted exponents of time and of memory along an axis."""
        points = self.along(axis)
        amounts = [one.point.amount for one in points]
        return (
            exponent(amounts, [one.epoch for one in points]),
            exponent(amounts, [float(one.memory) for one in points]),
        )

    def report(self) -> Report:
        """Return what was wanted, and what was reached."""
        bounds = {
            f"exponent of an epoch's time in {axis}": bound(
                np.array([self.exponents(axis)[0]]), _LINEAR, ""
            )
            for axis in _SHOULD_BE_LINEAR
        }
        *_, before, longest = self.along("steps")
        bounds[f"peak memory of {longest.point.steps:,} steps"] = bound(
            np.array([longest.memory / 1e9]), _LONGEST, "GB"
        )
        growth = np.array([float(longest.memory - before.memory)])
        inherent = np.array([float(longest.inherent - before.inherent)])
        return Report(
            ratios={
                "memory of a further step over that of motion and trace": ratio(
                    growth, inherent, 1.0
                )
            },
            bounds=bounds,
        )

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each point, for CSV and JSON."""
        return [
            {"varied": one.point.axis}
            | {name: getattr(one.point, name) for name in AXES}
            | {
                "epoch_s": one.epoch,
                "least_s": min(one.seconds),
                "greatest_s": max(one.seconds),
                "epochs": len(one.seconds),
                "memory_bytes": one.memory,
                "inherent_bytes": one.inherent,
            }
            for axis in AXES
            for one in self.along(axis)
        ]

    def markdown(self) -> str:
        """Return all points as a table, and a table of the exponents."""
        lines = ["| varied | amount | an epoch, s | least to greatest | peak memory, MB |"]
        lines.append("|---|---|---|---|---|")
        for axis in AXES:
            for one in self.along(axis):
                spread = f"{min(one.seconds):.3g} to {max(one.seconds):.3g}"
                lines.append(
                    f"| {axis} | {one.point.amount:,} | {one.epoch:.3g} | {spread}"
                    f" | {one.memory / 1e6:.0f} |"
                )
        lines += ["", "| varied | exponent of time | exponent of memory |", "|---|---|---|"]
        for axis in AXES:
            time, memory = self.exponents(axis)
            lines.append(f"| {axis} | {time:.2f} | {memory:.2f} |")
        return "\n".join(lines)


def exponent(amounts: Sequence[float], values: Sequence[float]) -> float:
    """Fit the exponent b of values a·amount^b by least squares of logarithms.

    The larger half of the amounts is fitted, since fixed costs bend the curve below.

    Args:
        amounts: Amounts, the least first, shape (N,), N at least 3.
        values: What was measured of each, shape (N,).
    """
    half = slice(len(amounts) // 2, None)
    slope, _ = np.polyfit(np.log(amounts[half]), np.log(values[half]), 1)
    return float(slope)


def measure(progress: Progress) -> Scaling:
    """Train at every point, one after the other, each in a process of its own.

    Args:
        progress: Shows how far the points are.
    """
    points = [Point(axis, **{axis: amount}) for axis, amounts in AXES.items() for amount in amounts]
    measured = []
    for number in progress(range(len(points)), "training at every size"):
        options = json.dumps(dataclasses.asdict(points[number]))
        said = json.loads(python("-m", "mpma_mj.bench.point", options))
        said |= {"point": points[number], "seconds": tuple(said["seconds"])}
        measured.append(Measured(**said))
    return Scaling(tuple(measured))
