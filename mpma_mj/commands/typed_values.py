"""Plants on the command line: `--plants default payload=3 actuator_gain=1.5,payload=1`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tyro.constructors import PrimitiveConstructorSpec, PrimitiveTypeInfo

from mpma_mj.envs.plants import Plant, plants_from
from mpma_mj.errors import BadOptionError

__all__ = ["plant_words"]

_DEFAULT = str(Plant())
_EXPECTED = f"{_DEFAULT}, or each option once, such as payload=3,actuator_gain=0.6"


def plant_words(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Return how plants are typed, a word each, its options between commas.

    Args:
        info: Type of an option; None is returned for other types than that of `plants`.
    """
    if info.type not in (tuple[Plant, ...], tuple[Plant, ...] | None):
        return None
    return PrimitiveConstructorSpec(
        nargs="*",
        metavar=f"[{_DEFAULT}|OPTION=NUMBER,… …]",
        instance_from_str=_parsed,
        is_instance=lambda plants: plants is None or isinstance(plants, tuple),
        str_from_instance=lambda plants: ["None"] if plants is None else [str(p) for p in plants],
    )


def _parsed(words: Sequence[str]) -> tuple[Plant, ...] | None:
    """Return the plants that the words describe.

    Raises:
        BadOptionError: There are no words, one describes no plant, or an option is out of bounds.
    """
    if not words:
        raise BadOptionError(f"--plants has no plant; expected {_EXPECTED}")
    return plants_from([{} if word == _DEFAULT else _options(word) for word in words])


def _options(word: str) -> dict[str, Any]:
    """Return the options of a plant as they are typed, numbers where they are numbers."""
    options: dict[str, Any] = {}
    for part in word.split(","):
        typed, equals, text = part.partition("=")
        name = typed.replace("-", "_")
        if not equals or name in options:
            raise BadOptionError(
                f"--plants has '{word}'; expected {_EXPECTED}",
                remedy="motions stand before {plants}",
            )
        try:
            options[name] = float(text)
        except ValueError:
            options[name] = text  # for the option to refuse
    return options
