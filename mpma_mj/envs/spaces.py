"""Gymnasium's spaces of actions and observations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

__all__: list[str] = ["action_space", "flatten", "observation_space"]

Array = NDArray[np.float64]

# Coordinates of unit vectors, sines and cosines may be rounded to a little more than 1.
_UNIT = (-1.0 - 1e-9, 1.0 + 1e-9)
_BOUNDS: dict[str, tuple[float, float]] = dict.fromkeys(
    ("posture", "reference", "target", "lookahead", "phase"), _UNIT
)
_BOUNDS["context"] = (0.0, 1.0)
# Shoulders have no limits and simulated arms overshoot theirs, so the only bound of angles and
# velocities is the one from which MuJoCo regards a simulation as diverged.
_NO_BOUND = (-mujoco.mjMAXVAL, mujoco.mjMAXVAL)


def action_space() -> spaces.Box[np.float32]:
    """Return the space of actions, float32 as learners expect."""
    return spaces.Box(-1.0, 1.0, (8,))


def observation_space(shapes: Mapping[str, tuple[int, ...]], *, flat: bool) -> spaces.Space[Any]:
    """Return the space of observations.

    Args:
        shapes: Shape of each array of an observation, by name.
        flat: Whether observations are one array, the concatenation of the others.
    """
    parts = {name: _box(_BOUNDS.get(name, _NO_BOUND), shape) for name, shape in shapes.items()}
    if not flat:
        return spaces.Dict(list(parts.items()))  # a dictionary would be sorted
    low = np.concatenate([part.low.ravel() for part in parts.values()])
    high = np.concatenate([part.high.ravel() for part in parts.values()])
    return spaces.Box(low, high, dtype=np.float64)


def flatten(observation: Mapping[str, Array], batch: tuple[int, ...] = ()) -> Array:
    """Return an observation as one array, shape (*batch, sum of the sizes)."""
    return np.concatenate([part.reshape(*batch, -1) for part in observation.values()], axis=-1)


def _box(bounds: tuple[float, float], shape: tuple[int, ...]) -> spaces.Box[np.float64]:
    return spaces.Box(*bounds, shape, dtype=np.float64)
