"""Measures of finished runs, over seeds."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mpma_mj.experiments.folder import RunResult, flat
from mpma_mj.experiments.spec import without_seed
from mpma_mj.training.config import RunConfig

__all__ = ["Spread", "converged", "of_point", "remarks", "spread", "value", "values"]


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation over seeds.

    Attributes:
        mean: Mean; NaN of no value.
        deviation: Standard deviation of the sample, with N - 1; NaN of fewer than two values.
    """

    mean: float
    deviation: float

    def text(self, digits: int, between: str = " ± ") -> str:
        """Return both with so many digits after the point; a dash for what is not there."""
        parts = (
            f"{x:.{digits}f}" if math.isfinite(x) else "–" for x in (self.mean, self.deviation)
        )
        return between.join(parts)


def of_point(runs: Sequence[RunResult], point: RunConfig) -> list[RunResult]:
    """Return the runs of settings that differ in their seed only."""
    return [run for run in runs if without_seed(run.config) == point]


def converged(runs: Sequence[RunResult]) -> int:
    """Count the runs that converged."""
    return sum(bool(run.summary.get("converged")) for run in runs)


def value(run: RunResult, measure: str) -> float | None:
    """Return a measure of a run, None if it has none.

    Args:
        run: The run.
        measure: Its name in a summary; "active_modules.Y" for an entry of an entry, and
            "active_modules" for the mean over its entries.
    """
    found = run.summary.get(measure, flat(run.summary).get(measure))
    if isinstance(found, Mapping):
        return statistics.fmean(found.values())
    return None if found is None else float(found)


def values(runs: Sequence[RunResult], measure: str) -> list[float]:
    """Return a measure of all runs that have it.

    Runs that diverged have none, and neither have some agents; those that did not converge
    count with their best epoch (choice).

    Args:
        runs: RunResult runs.
        measure: Its name, as of `value`.
    """
    found = (value(run, measure) for run in runs)
    return [number for number in found if number is not None]


def spread(runs: Sequence[RunResult], measure: str) -> Spread:
    """Return mean and deviation of a measure; see `values`."""
    found = values(runs, measure)
    return Spread(
        statistics.fmean(found) if found else math.nan,
        statistics.stdev(found) if len(found) > 1 else math.nan,
    )


def remarks(runs: Sequence[RunResult], requested: int) -> list[str]:
    """Return a sentence for each kind of irregularity: missing, diverged and repeated runs.

    Args:
        runs: The finished runs.
        requested: Number of requested runs.
    """
    diverged = sum(run.diverged for run in runs)
    again = sum(run.attempts > 1 for run in runs)
    counts = {
        f"{requested - len(runs)} of {requested} runs are missing, because their workers died or"
        " the command was stopped; start it again to go on.": requested - len(runs),
        f"{diverged} of {requested} runs diverged; they count in no mean.": diverged,
        f"{again} of {requested} runs were tried again, because their worker died.": again,
    }
    return [sentence for sentence, count in counts.items() if count]
