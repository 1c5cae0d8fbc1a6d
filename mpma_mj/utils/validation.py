"""What values are, of Python's types or numpy's."""

from __future__ import annotations

from numbers import Integral, Real
from typing import SupportsFloat, SupportsInt, TypeGuard

import numpy as np

__all__ = ["is_boolean", "is_integer", "is_number"]


def is_integer(value: object) -> TypeGuard[SupportsInt]:
    """Tell whether a value is a whole number, and not True or False."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_number(value: object) -> TypeGuard[SupportsFloat]:
    """Tell whether a value is a real number, and not True or False."""
    return isinstance(value, Real) and not isinstance(value, bool)


def is_boolean(value: object) -> TypeGuard[bool | np.bool_]:
    """Tell whether a value is True or False."""
    return isinstance(value, bool | np.bool_)
