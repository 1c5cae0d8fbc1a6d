"""Means over seeds with bootstrap confidence intervals."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

__all__ = ["Interval", "interval"]

_LEVEL = 0.95
_RESAMPLES = 9999


@dataclass(frozen=True)
class Interval:
    """A mean and its 95 % confidence interval.

    Attributes:
        mean: Mean; NaN if there is no value.
        low: Lower end; NaN for fewer than two values.
        high: Upper end; NaN for fewer than two values.
    """

    mean: float
    low: float
    high: float

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval lies on one side of 0."""
        return self.low > 0 or self.high < 0

    def text(self, digits: int, sign: str = "") -> str:
        """Return "mean [low, high]", or the mean alone if the interval is a point or unknown.

        Args:
            digits: Number of digits after the decimal point.
            sign: "+" to show the sign of positive numbers too.
        """
        if not math.isfinite(self.mean):
            return "–"
        mean, low, high = (f"{x:{sign}.{digits}f}" for x in (self.mean, self.low, self.high))
        return f"{mean} [{low}, {high}]" if self.high > self.low else mean

    def columns(self, name: str) -> dict[str, float]:
        """Return the numbers by their columns in a table, such as `NAME_mean`."""
        return {f"{name}_{part}": value for part, value in vars(self).items()}


def interval(found: Sequence[float]) -> Interval:
    """Return the mean of values, one for each seed, and its bootstrap confidence interval.

    The ends are percentiles of the means of 9999 resamples, with a fixed seed (choice). For few
    values such an interval tends to be too narrow.
    """
    if not found:
        return Interval(math.nan, math.nan, math.nan)
    mean = statistics.fmean(found)
    if len(found) == 1:
        return Interval(mean, math.nan, math.nan)
    if min(found) == max(found):
        return Interval(found[0], found[0], found[0])
    ends = stats.bootstrap(
        (np.asarray(found),),
        np.mean,
        confidence_level=_LEVEL,
        n_resamples=_RESAMPLES,
        method="percentile",
        rng=np.random.default_rng(0),
    ).confidence_interval
    return Interval(mean, float(ends.low), float(ends.high))
