"""Validation of actions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpma_mj.errors import BadOptionError

__all__: list[str] = ["check_action"]

Array = NDArray[np.float64]


def check_action(action: ArrayLike, shape: tuple[int, ...] = (8,)) -> Array:
    """Return an action as float64.

    Args:
        action: Joint velocities over the joints' top speeds, shape (..., 8).
        shape: Expected shape.

    Raises:
        BadOptionError: The action has another shape or type, or an entry is no finite number;
            names the entry.
    """
    try:
        given = np.asarray(action)
    except ValueError:  # rows of different lengths
        raise BadOptionError(f"action is no array; expected shape {shape}") from None
    if given.dtype.kind not in "fiu":
        raise BadOptionError(f"action is of type {given.dtype}; expected float64, shape {shape}")
    if given.shape != shape:
        raise BadOptionError(f"action has shape {given.shape}; expected {shape}")
    values = np.asarray(given, np.float64)
    # The sum of squares is finite only if all entries are, and costs a third of `isfinite`.
    if not np.vdot(values, values) < np.inf:
        unfit = np.argwhere(~np.isfinite(values))
        if len(unfit):
            entry = ", ".join(map(str, unfit[0]))
            raise BadOptionError(
                f"action[{entry}] is {values[tuple(unfit[0])]}; expected numbers in [-1, 1]"
            )
    return values
