"""The gain of the feedback controller that assists."""

from __future__ import annotations

from mpma_mj.errors import BadOptionError

__all__ = ["check_gain"]


def check_gain(gain: float) -> float:
    """Return a gain.

    Raises:
        BadOptionError: It is not between 0 and 1.
    """
    if not 0.0 <= gain <= 1.0:
        raise BadOptionError(f"gain is {gain:g}; expected 0 to 1")
    return gain
