"""Fast clipping of small arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["clip"]

Array = NDArray[np.float64]


# As arrays: of Python's numbers numpy makes one in each call, which takes half of its time.
_LOW, _HIGH = np.array(-1.0), np.array(1.0)


def clip(values: Array, low: float | Array = _LOW, high: float | Array = _HIGH) -> Array:
    """Return values, any shape, clipped to [low, high], by default to [-1, 1]."""
    return np.minimum(np.maximum(values, low), high)  # twice as fast as np.clip
