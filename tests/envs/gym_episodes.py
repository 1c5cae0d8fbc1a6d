"""Environments of Gymnasium and actions, for tests of their interface."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DICTIONARY, FLAT = NAMES = ("TwoArmImitation-v0", "TwoArmImitationFlat-v0")


def make(name: str = DICTIONARY, **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(f"mpma_mj:{name}", **{"repeats": 1, **options})


def actions(count: int, seed: int = 0) -> Array:
    """Return actions, some beyond the bounds, that drive elbows into their limits too."""
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (count, 8)).cumsum(axis=0).clip(-1.5, 1.5)


def assert_same(one: Any, other: Any) -> None:
    """Compare what `reset` or `step` returned, bit for bit."""
    for a, b in zip(one, other, strict=True):
        if isinstance(a, dict):
            assert a.keys() == b.keys()
            assert_same(a.values(), b.values())
        else:
            np.testing.assert_array_equal(a, b)
