"""Latency on the command line: `--latency 3`, or `--latency 0 5` for a range."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tyro.constructors import PrimitiveConstructorSpec, PrimitiveTypeInfo

from mpma_mj.errors import BadOptionError

__all__ = ["latency_words"]


def latency_words(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Return how latency is typed: one number, or lowest and highest.

    Args:
        info: Type of an option; None is returned for other types than that of `latency`.
    """
    if info.type != int | tuple[int, int]:
        return None
    return PrimitiveConstructorSpec(
        nargs="*",
        metavar="STEPS|{LOW HIGH}",
        instance_from_str=_parsed,
        is_instance=lambda latency: isinstance(latency, int | tuple),
        str_from_instance=lambda latency: (
            [str(latency)] if isinstance(latency, int) else [str(steps) for steps in latency]
        ),
    )


def _parsed(words: Sequence[str]) -> int | tuple[int, int]:
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
        raise BadOptionError(
            f"--latency has '{' '.join(words)}'; expected one whole number, such as 3, or a range"
            " of two, such as 0 5",
            remedy="put motions before {latency}",
        ) from None
    return first, second
