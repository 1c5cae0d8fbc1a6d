"""The gain of the feedback controller that assists."""

from __future__ import annotations

from numbers import Real

from mpma_mj.errors import BadOptionError

__all__ = ["check_gain"]


def check_gain(gain: float) -> float:
    """Return a gain.

    Raises:
        BadOptionError: It is not between 0 and 1.
    """
    if isinstance(gain, bool) or not (isinstance(gain, Real) and 0.0 <= gain <= 1.0):
        raise BadOptionError(f"gain is {gain!r}; expected 0 to 1")
    return float(gain)
