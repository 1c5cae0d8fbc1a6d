"""Which latencies fit a log as well as the one that was found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.sysid.fit import Fit, refit, robust_loss
from mpma_mj.sysid.misfit import Misfit
from mpma_mj.sysid.uncertainty import NORMAL

__all__ = ["latency_interval"]

Array = NDArray[np.float64]

_FARTHEST = 5  # physics steps that are tried to each side (choice)


def latency_interval(misfit: Misfit, found: Fit, longest: int) -> tuple[int, int]:
    """Return the least and the greatest latency that fit as well, physics steps.

    With each the parameters are fitted anew. It fits worse if the windows' losses are greater by
    1.96 standard errors of their mean difference.

    Args:
        misfit: Windows that are compared; the fewer, the wider the interval.
        found: What was found.
        longest: Longest latency that is possible.
    """
    least = _losses(misfit, found, found.logs, found.latency)
    ends = []
    for way in (-1, 1):
        end = found.latency
        while 0 <= end + way <= longest and abs(end + way - found.latency) <= _FARTHEST:
            logs = refit(misfit, found, end + way)
            more = _losses(misfit, found, logs, end + way) - least
            if more.mean() > NORMAL * more.std(ddof=1) / np.sqrt(len(more)):
                break
            end += way
        ends.append(end)
    return ends[0], ends[1]


def _losses(misfit: Misfit, found: Fit, logs: Array, latency: int) -> Array:
    """Return each window's loss, shape (W,)."""
    return robust_loss(misfit.residual(logs, latency), found.scale).sum(axis=1)
