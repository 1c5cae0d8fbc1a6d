"""Arrays from files: what they have to hold, and assignment that checks it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Expected", "array_problem", "assign", "shared_count"]

# Far above what simulations give, and its square is still a number (choice).
_LARGEST = 1e30


@dataclass(frozen=True)
class Expected:
    """What an array has to hold.

    Attributes:
        shape: Its shape; names stand for lengths, which are the same in all arrays.
        largest: Largest absolute value.
        kinds: Kinds of its type, as in NumPy.
    """

    shape: tuple[int | str, ...]
    largest: float = _LARGEST
    kinds: str = "fiu"


def array_problem(arrays: Mapping[str, NDArray[Any]], expected: Mapping[str, Expected]) -> str:
    """Return what is wrong with arrays by name, to follow the name of their file, or ""."""
    lengths: dict[str, int] = {}
    for name, wanted in expected.items():
        if name not in arrays:
            return f"lacks {name}"
        array = arrays[name]
        named = zip(wanted.shape, array.shape, strict=False)
        lengths |= {key: n for key, n in named if isinstance(key, str) and key not in lengths}
        shape = tuple(lengths.get(n, 0) if isinstance(n, str) else n for n in wanted.shape)
        if array.shape != shape or array.dtype.kind not in wanted.kinds:
            return f"has {name} {array.dtype}{array.shape}; expected numbers of shape {shape}"
        if not (np.abs(array) <= wanted.largest).all():  # also NaN
            return f"has a value in {name} that is NaN or beyond ±{wanted.largest:g}"
    return ""


def assign(
    array: NDArray[Any],
    value: NDArray[Any],
    *,
    low: float = -_LARGEST,
    high: float = _LARGEST,
    nan: bool = False,
) -> None:
    """Overwrite an array with one of its shape and type; NumPy alone would broadcast and convert.

    Args:
        array: The array, of numbers; integers are counts.
        value: Its new content.
        low: Lowest value; 0 of counts.
        high: Highest value.
        nan: Whether NaN is a value, too.

    Raises:
        ValueError: The content is of another shape or type, or out of bounds.
    """
    value = np.asarray(value)
    if value.shape != array.shape or value.dtype != array.dtype:
        raise ValueError(f"{value.dtype}{value.shape} in place of {array.dtype}{array.shape}")
    lowest = max(low, 0.0) if array.dtype.kind in "iu" else low
    within = (value >= lowest) & (value <= high)
    if not (within | np.isnan(value) if nan else within).all():
        raise ValueError(f"a value that is not one from {lowest:g} to {high:g}")
    array[...] = value


def shared_count(value: NDArray[Any], shape: tuple[int, ...]) -> int:
    """Return a count that is the same in all runs of a shape.

    Raises:
        ValueError: It is of another shape or type, or negative.
    """
    count = np.zeros(shape, np.int64)
    assign(count, value)
    return int(np.max(count))
