"""Checks of options of environments that are no single numbers."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import SEGMENT_NAMES
from mpma_mj.utils.validation import Bounds, is_number

__all__: list[str] = [
    "checked_dwell",
    "checked_perturbation",
    "checked_robot",
    "checked_weights",
    "is_within",
]

_WEIGHT = Bounds(0.0, 1e6)
_RATE, _FORCE = Bounds(0.0, 100.0), Bounds(0.0, 10_000.0)  # 1/s, N
_DWELL = Bounds(0.0, 1e6, above=True)  # s


def checked_robot(robot: object) -> str:
    """Return the name or the path of a robot as text; raises a BadOptionError for anything else."""
    if not isinstance(robot, str | Path):
        raise BadOptionError(option="robot", value=robot, expected="a name or a path")
    name = os.fspath(robot)
    # A path is kept as an absolute one, as a run looks for its robot from anywhere.
    return os.fspath(Path(name).absolute()) if Path(name).suffix else name


def is_within(bounds: Bounds, value: object) -> bool:
    """Return whether a value is a number within bounds."""
    return is_number(value) and bounds.admit(value)  # type: ignore[arg-type] # compared as it is


def checked_perturbation(given: Any) -> tuple[float, float]:
    """Return rate, 1/s, and size, N, as plain numbers; a BadOptionError if out of bounds."""
    rate, size = _pair(given)
    if not (is_within(_RATE, rate) and is_within(_FORCE, size)):
        raise BadOptionError(
            option="perturbation",
            value=given,
            expected="rate (0 to 100 a second) and size (0 to 10000 N), such as 0.5 and 30",
        )
    return float(rate), float(size)


def checked_dwell(option: str, given: Any) -> tuple[float, float]:
    """Return lowest and highest time between two switches, s; a BadOptionError if out of bounds."""
    low, high = _pair(given)
    if not (is_within(_DWELL, low) and is_within(_DWELL, high) and low <= high):
        expected = f"two times, 0 < low <= high <= {_DWELL.high:g} s, such as 1 and 3"
        raise BadOptionError(option=option, value=given, expected=expected)
    return float(low), float(high)


def _pair(given: Any) -> tuple[Any, Any]:
    """Return two entries; numbers that no option admits where there are not two."""
    is_pair = isinstance(given, tuple | list | np.ndarray) and len(given) == 2
    first, second = given if is_pair else (-1.0, -1.0)
    return first, second


def checked_weights(given: object) -> dict[str, float]:
    """Return a copy of the weights as plain numbers; a BadOptionError if out of bounds."""
    if not isinstance(given, Mapping) or not given.keys() <= set(SEGMENT_NAMES):
        expected = f"a weight for some of {', '.join(SEGMENT_NAMES)}"
        raise BadOptionError(option="reward_weights", value=given, expected=expected)
    for name, weight in given.items():
        if not is_within(_WEIGHT, weight):
            expected = f"0 to {_WEIGHT.high:g} for {name}"
            raise BadOptionError(option="reward_weights", value=dict(given), expected=expected)
    if len(given) == len(SEGMENT_NAMES) and not any(given.values()):
        raise BadOptionError(
            option="reward_weights", value=dict(given), expected="at least one above 0"
        )
    return {name: float(weight) for name, weight in given.items()}
