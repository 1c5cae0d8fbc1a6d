"""Gymnasium's conventions for vectors: modes of autoreset, masks of a reset, layout of `info`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from mpma_mj.envs.step_rules import Mask
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import is_integer

__all__: list[str] = [
    "check_going",
    "check_no_options",
    "checked_autoreset",
    "checked_count",
    "checked_reset_mask",
    "masked",
    "row_of",
    "rows_where",
]

_MOST = 100_000  # environments or threads (choice)


def checked_count(name: str, count: object) -> int:
    """Return a number of environments or threads, given the name of its option.

    Raises:
        BadOptionError: It is no whole number from 1 to 100,000.
    """
    if not (is_integer(count) and 1 <= int(count) <= _MOST):
        expected = f"a whole number from 1 to {_MOST}"
        raise BadOptionError(option=name, value=count, expected=expected)
    return int(count)


def check_going(over: Mask) -> None:
    """Check that no episode is over, given which are, shape (N,).

    Raises:
        ResetNeeded: One is over.
    """
    if over.any():
        rows = ", ".join(map(str, np.flatnonzero(over)))
        mask = 'options={"reset_mask": terminated | truncated}'
        raise gymnasium.error.ResetNeeded(
            f"the episodes of environments {rows} are over; call reset, with {mask} for these"
        )


def checked_autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    """Return a mode of autoreset, given as it is or by either of Gymnasium's names.

    Raises:
        BadOptionError: There is no such mode.
    """
    for known in AutoresetMode if isinstance(mode, AutoresetMode | str) else ():
        if mode in (known, known.name, known.value):
            return known
    expected = "NEXT_STEP, SAME_STEP or DISABLED"
    raise BadOptionError(option="autoreset_mode", value=mode, expected=expected)


def check_no_options(options: object) -> None:
    """Check that `reset` has no options: None, or a dictionary without entries.

    Raises:
        BadOptionError: There are some.
    """
    if options is not None and not (isinstance(options, dict) and not options):
        expected = "none, as reset has no options"
        raise BadOptionError(option="options", value=options, expected=expected)


def checked_reset_mask(options: dict[str, Any] | None, count: int) -> NDArray[np.bool_]:
    """Return which environments are to be reset, shape (N,): all if there are no options.

    Args:
        options: Options of `reset`, such as {"reset_mask": mask}.
        count: Number N of environments.

    Raises:
        BadOptionError: There are other options, or the mask is no array of N booleans.
    """
    if options is None or (isinstance(options, dict) and not options):
        return np.ones(count, bool)
    try:
        mask = np.array(options.get("reset_mask")) if isinstance(options, dict) else None
    except ValueError:  # rows of different lengths
        mask = None
    expected = (np.dtype(bool), (count,))
    if mask is None or (mask.dtype, mask.shape) != expected or len(options) > 1:
        raise BadOptionError(
            option="options",
            value=options,
            expected=f"None, or a reset_mask of {count} booleans",
        )
    return mask


def masked(info: Mapping[str, Any], mask: Mask) -> dict[str, Any]:
    """Return entries with the mask of the environments that have them.

    Args:
        info: Entries by name, each of shape (N,) or a dictionary of such.
        mask: Which environments have these entries, shape (N,). The others have 0, or None where
            entries are objects.
    """
    found: dict[str, Any] = {}
    whole = mask.all()
    for name, value in info.items():
        if isinstance(value, dict):
            found[name] = masked(value, mask)
        elif whole:
            found[name] = value
        else:
            found[name] = np.where(
                mask, value, None if value.dtype == object else value.dtype.type()
            )
        found[f"_{name}"] = mask.copy()
    return found


def row_of(info: Mapping[str, Any], row: int) -> dict[str, Any]:
    """Return the entries that one environment has, as its own `info`."""
    return {
        name: row_of(value, row) if isinstance(value, dict) else value[row]
        for name, value in info.items()
        if not name.startswith("_") and info[f"_{name}"][row]
    }


def rows_where(mask: Mask, observation: Any) -> NDArray[np.object_]:
    """Return observations one by one, None elsewhere, shape (N,).

    Args:
        mask: Which environments' to return, shape (N,).
        observation: Observations with an axis N in front: an array, or arrays by name.
    """
    rows = np.full(np.shape(mask), None, object)
    for row in np.flatnonzero(mask):
        if isinstance(observation, dict):
            rows[row] = {name: part[row] for name, part in observation.items()}
        else:
            rows[row] = observation[row]
    return rows
