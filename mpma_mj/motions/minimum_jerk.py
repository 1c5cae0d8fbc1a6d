"""Movement from pose to pose as people do it: with minimum jerk."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["PEAK_SPEED", "minimum_jerk"]

PEAK_SPEED = 15.0 / 8.0  # of a minimum-jerk move of distance 1 in time 1, reached half-way


def minimum_jerk(phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share of the way that is done at a share of the time.

        s(τ) = 10 τ³ - 15 τ⁴ + 6 τ⁵        Flash & Hogan 1985, J. Neuroscience 5(7)

    Args:
        phase: Share of the time τ, any shape; before 0 and after 1 the move rests.

    Returns:
        Share of the way, same shape, in [0, 1].
    """
    tau = np.clip(phase, 0.0, 1.0)
    return tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2)
