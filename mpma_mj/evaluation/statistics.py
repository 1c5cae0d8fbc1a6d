"""Statistics over seeds: means with standard deviations or with bootstrap confidence intervals."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Interval", "MeanStd", "interval", "mean_std"]

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


@dataclass(frozen=True)
class MeanStd:
    """A mean and its standard deviation.

    Attributes:
        mean: Mean; NaN if there is no value.
        std: Standard deviation of the sample, with N - 1; NaN for fewer than two values.
    """

    mean: float
    std: float

    def text(self, digits: int, between: str = " ± ") -> str:
        """Return both numbers, a dash for NaN.

        Args:
            digits: Number of digits after the decimal point.
            between: What stands between the numbers.
        """
        parts = (f"{x:.{digits}f}" if math.isfinite(x) else "–" for x in (self.mean, self.std))
        return between.join(parts)


def mean_std(found: Sequence[float]) -> MeanStd:
    """Return mean and standard deviation of values, one for each seed."""
    return MeanStd(
        statistics.fmean(found) if found else math.nan,
        statistics.stdev(found) if len(found) > 1 else math.nan,
    )


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
    import numpy as np
    from scipy import stats  # takes half a second, which the command's help saves

    ends = stats.bootstrap(
        (np.asarray(found),),
        np.mean,
        confidence_level=_LEVEL,
        n_resamples=_RESAMPLES,
        method="percentile",
        rng=np.random.default_rng(0),
    ).confidence_interval
    return Interval(mean, float(ends.low), float(ends.high))
