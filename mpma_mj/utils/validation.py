"""Validation of options: bounds declared with the fields of dataclasses."""

from __future__ import annotations

import dataclasses
import functools
import types
from dataclasses import dataclass
from numbers import Integral, Real
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    SupportsFloat,
    SupportsInt,
    TypeAlias,
    TypeGuard,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from mpma_mj.errors import BadOptionError

__all__ = ["Bounds", "Range", "check_fields", "is_boolean", "is_integer", "is_number"]


Range: TypeAlias = tuple[float, float]
"""Lowest and highest number."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of a number, as annotation of a field: `nodes: Annotated[int, Bounds(1, 20000)]`.

    Attributes:
        low: Lowest value.
        high: Highest value.
        above: Whether the lowest value itself is excluded.
        below: Whether the highest value itself is excluded.
        hint: Unit or example, for messages.
    """

    low: float
    high: float
    above: bool = False
    below: bool = False
    hint: str = ""

    def admit(self, value: float) -> bool:
        """Return whether a number is within the bounds; NaN is not."""
        over = value > self.low if self.above else value >= self.low
        return over and (value < self.high if self.below else value <= self.high)

    def describe(self, *, whole: bool) -> str:
        """Return the bounds in words.

        Args:
            whole: Whether the number is an integer.
        """
        if whole:
            bounds = f"a whole number from {self.low:g} to {self.high:g}"
        elif self.above or self.below:
            low = f"above {self.low:g}" if self.above else f"{self.low:g} or more"
            bounds = f"{low}, {'below' if self.below else 'at most'} {self.high:g}"
        else:
            bounds = f"{self.low:g} to {self.high:g}"
        return f"{bounds}, {self.hint}" if self.hint else bounds


def check_fields(options: object) -> None:
    """Check the fields of a dataclass against their annotations, and convert them to plain Python.

    Numbers must be annotated with `Bounds`. Numbers, Booleans and literals are checked, also
    where None is allowed too; so are numbers or ranges of two, `Annotated[float, Bounds(0, 1)] |
    tuple[float, float]`. Other types are left to the class itself.

    Args:
        options: Instance of a dataclass, which may be frozen; call it in `__post_init__`.

    Raises:
        BadOptionError: A value is of another type, or out of bounds; the error names the field.
    """
    for name, check in _checked_fields(type(options)).items():  # type: ignore[arg-type] # classes are hashable
        value = getattr(options, name)
        if (value is None or isinstance(value, str)) and value in check.words:
            continue
        object.__setattr__(options, name, _checked(name, value, check))


class _Check(NamedTuple):
    """Type of a field, bounds of a number, words or None, and whether a range is allowed."""

    kind: Any
    bounds: Bounds | None
    words: tuple[str | None, ...]
    ranged: bool


@functools.cache
def _checked_fields(owner: type) -> dict[str, _Check]:
    """Return how to check each of the fields that are to be checked."""
    hints = get_type_hints(owner, include_extras=True)
    checked = {}
    for field in dataclasses.fields(owner):
        kind, bounds = _unwrap(hints[field.name])
        choices = get_args(kind) if get_origin(kind) in (Union, types.UnionType) else (kind,)
        words: list[str | None] = [None for choice in choices if choice is types.NoneType]
        others = [choice for choice in choices if choice is not types.NoneType]
        if len(others) == 2 and get_origin(others[1]) is Literal:
            words += get_args(others.pop())
        ranged = len(others) == 2 and get_args(others[1]) == 2 * (_unwrap(others[0])[0],)
        if len(others) == 1 or ranged:
            kind, inner = _unwrap(others[0])
            checked[field.name] = _Check(kind, bounds or inner, tuple(words), ranged)
    return {
        name: check
        for name, check in checked.items()
        if check.kind is bool or get_origin(check.kind) is Literal or check.bounds is not None
    }


def _unwrap(hint: Any) -> tuple[Any, Bounds | None]:
    """Return the type behind an annotation, and its bounds if it has any."""
    if get_origin(hint) is not Annotated:
        return hint, None
    kind, *extras = get_args(hint)
    return kind, next((extra for extra in extras if isinstance(extra, Bounds)), None)


def _checked(name: str, value: Any, check: _Check) -> Any:
    """Return a valid value as plain Python of its type."""
    kind, bounds, words, ranged = check
    others = "".join(f", or {word}" for word in words if word)
    if kind is bool:
        if not is_boolean(value):
            raise BadOptionError(option=name, value=value, expected=f"True or False{others}")
        return bool(value)
    if get_origin(kind) is Literal:
        if not isinstance(value, str) or value not in get_args(kind):
            expected = f"one of {', '.join(get_args(kind))}"
            raise BadOptionError(option=name, value=value, expected=expected)
        return value
    assert bounds is not None
    whole = kind is int
    several = ranged and isinstance(value, tuple | list | np.ndarray)
    numbers = list(value) if several else [value]
    fit = all((is_integer(n) if whole else is_number(n)) and bounds.admit(n) for n in numbers)
    if not fit or (several and not (len(numbers) == 2 and numbers[0] <= numbers[1])):
        if ranged:
            others += ", or a range of two, the lowest first"
        expected = bounds.describe(whole=whole) + others
        raise BadOptionError(option=name, value=value, expected=expected)
    return tuple(map(kind, numbers)) if several else kind(value)


def is_integer(value: object) -> TypeGuard[SupportsInt]:
    """Return whether a value is an integer of Python or numpy, and not True or False."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_number(value: object) -> TypeGuard[SupportsFloat]:
    """Return whether a value is a real number of Python or numpy, and not True or False."""
    return isinstance(value, Real) and not isinstance(value, bool)


def is_boolean(value: object) -> TypeGuard[bool | np.bool_]:
    """Return whether a value is True or False, of Python or numpy."""
    return isinstance(value, bool | np.bool_)
