"""Options that are typed in a form of their own: ranges, plants, choices and several values.

`--latency 3`, or `--latency 0 5` for a range; `--plants default payload=3 payload=1,damping=2`.
"""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin

import tyro
from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from mpma_mj.envs.plants import Plant, plants_from
from mpma_mj.errors import BadOptionError

__all__ = ["some_values", "typed_value"]

_POSITIONAL: Any = tyro.conf.Positional

_DEFAULT = str(Plant())
_PLANTS = f"{_DEFAULT}, or each option once, such as payload=3,actuator_gain=0.6"


def typed_value(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Return how an option is typed, by its type; None for types that are typed as usual."""
    match get_args(info.type):
        case (names, types.NoneType) if get_origin(names) is Literal:
            return _choice(get_args(names))
    form = _number_or_range(info.type) or _FORMS.get(info.type)
    if form is None:
        return None
    return PrimitiveConstructorSpec(
        nargs="*",
        metavar=form.metavar,
        instance_from_str=form.parse,
        is_instance=lambda value: value is None or isinstance(value, int | float | tuple),
        str_from_instance=lambda value: list(
            map(str, value if isinstance(value, tuple) else [value])
        ),
    )


def some_values(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Return how an option of several values is typed: as usual, but not without a value."""
    several = get_args(info.type)[1:] == (...,) or get_origin(info.type) is Mapping
    if not several or _POSITIONAL in info.markers:
        return None
    # What tyro itself makes of it, as this marker stops the next call of this function.
    spec = ConstructorRegistry.get_primitive_spec(
        dataclasses.replace(info, markers=info.markers | {_POSITIONAL})
    )
    if not isinstance(spec, PrimitiveConstructorSpec):
        return None

    usual = spec.instance_from_str

    def parse(words: list[str]) -> Any:
        if not words:
            raise ValueError("no value")
        return usual(words)

    return dataclasses.replace(spec, instance_from_str=parse)


def _choice(choices: tuple[str, ...]) -> PrimitiveConstructorSpec[Any]:
    """Return how one of several names is typed, in place of None; tyro itself shuffles them."""
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{{{','.join(choices)}}}",
        choices=choices,
        instance_from_str=lambda words: words[0],
        is_instance=lambda value: value is None or value in choices,
        str_from_instance=lambda value: [str(value)],
    )


def _number_or_range(kind: Any) -> _Form | None:
    """Return how one number is typed, or a range of two; None for other types."""
    single, *others = get_args(kind) or (None,)
    number = get_args(single)[0] if get_origin(single) is Annotated else single
    if len(others) != 1 or get_args(others[0]) != (number, number):
        return None
    if number is int:
        expected = "one whole number, such as 3, or a range of two, such as 0 5"
    else:
        expected = "one number, or a range of two, the lowest first"

    def parse(words: Sequence[str]) -> Any:
        found = f"has '{' '.join(words)}'" if words else "has no value"
        try:
            numbers = tuple(map(number, words))
        except ValueError:
            numbers = ()
        if len(numbers) not in (1, 2):
            raise ValueError(f"{found}; expected {expected}")
        return numbers if len(numbers) == 2 else numbers[0]

    return _Form("STEPS|{LOW HIGH}" if number is int else "NUMBER|{LOW HIGH}", parse)


def _plants(words: Sequence[str]) -> tuple[Plant, ...] | None:
    """Return the plants that the words describe.

    Raises:
        BadOptionError: There are no words, one describes no plant, or an option is out of bounds.
    """
    if not words:
        raise BadOptionError(f"--plants has no plant; expected {_PLANTS}")
    return plants_from([{} if word == _DEFAULT else _plant(word) for word in words])


def _plant(word: str) -> dict[str, Any]:
    """Return the options of a plant as they are typed, numbers where they are numbers."""
    options: dict[str, Any] = {}
    for part in word.split(","):
        typed, equals, text = part.partition("=")
        name = typed.replace("-", "_")
        if not equals or name in options:
            raise BadOptionError(
                f"--plants has '{word}'; expected {_PLANTS}",
                remedy="put motions before {plants}",
            )
        try:
            options[name] = float(text)
        except ValueError:
            options[name] = text  # for the option to refuse
    return options


class _Form(NamedTuple):
    metavar: str
    parse: Callable[[Sequence[str]], Any]


_FORMS: dict[Any, _Form] = {
    tuple[Plant, ...]: _Form(f"[{_DEFAULT}|OPTION=NUMBER,… …]", _plants),
    tuple[Plant, ...] | None: _Form(f"[{_DEFAULT}|OPTION=NUMBER,… …]", _plants),
}
