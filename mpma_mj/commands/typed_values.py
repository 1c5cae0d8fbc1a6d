"""Options that are typed in a form of their own: latencies, plants, choices and several values.

`--latency 3`, or `--latency 0 5` for a range; `--plants default payload=3 payload=1,damping=2`.
"""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, get_args, get_origin

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
    form = _FORMS.get(info.type)
    if form is None:
        return None
    return PrimitiveConstructorSpec(
        nargs="*",
        metavar=form.metavar,
        instance_from_str=form.parse,
        is_instance=lambda value: value is None or isinstance(value, int | tuple),
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


def _latency(words: Sequence[str]) -> int | tuple[int, int]:
    """Return the latency that the words are; its bounds are for the option to check.

    Raises:
        BadOptionError: They are neither one whole number nor two.
    """
    try:
        first, *others = map(int, words)
        if not others:
            return first
        (second,) = others
    except ValueError:
        found = f"'{' '.join(words)}'" if words else "no value"
        raise BadOptionError(
            f"--latency has {found}; expected one whole number, such as 3, or a range"
            " of two, such as 0 5",
            remedy="put motions before {latency}",
        ) from None
    return first, second


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
    int | tuple[int, int]: _Form("STEPS|{LOW HIGH}", _latency),
    tuple[Plant, ...]: _Form(f"[{_DEFAULT}|OPTION=NUMBER,… …]", _plants),
    tuple[Plant, ...] | None: _Form(f"[{_DEFAULT}|OPTION=NUMBER,… …]", _plants),
}
