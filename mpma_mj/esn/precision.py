"""The precision in which reservoirs and readouts compute.

In single precision a reservoir's weights are half as large, and how fast it steps is how fast they
come from memory; sums of features are formed in half the time. What it changes is in
docs/performance.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["PRECISION", "Features", "Single"]

PRECISION = np.float32
Single = NDArray[np.float32]
Features = NDArray[np.floating[Any]]
"""What readouts take, of any precision."""
