"""Floating-point precision of reservoirs and readouts.

A reservoir's speed is the bandwidth at which its weights are read, which single precision halves,
as it halves the time for sums of features; docs/results/performance.md has what
results differ by.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["PRECISION", "Features", "Single"]

PRECISION = np.float32
Single = NDArray[np.float32]
Features = NDArray[np.floating[Any]]
"""Input of readouts, of any precision."""
