"""Faults that a campaign finds, and its parts as rows of a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from mpma_mj.utils.text import markdown_table

__all__ = ["Fault", "Part", "report"]


class Fault(NamedTuple):
    """Something that must not happen.

    Attributes:
        what: What happened.
        repeat: What repeats it: words of the command, number of the operation.
    """

    what: str
    repeat: str


class Part(NamedTuple):
    """Result of a part of the campaign.

    Attributes:
        name: What was tried.
        tries: How often.
        possible: How often is everything, where that is known.
        faults: What was found.
        note: Further figures.
    """

    name: str
    tries: int
    possible: int | None
    faults: Sequence[Fault]
    note: str = ""


def report(parts: Sequence[Part]) -> str:
    """Return the faults, a line each, and a table of all parts in Markdown."""
    lines = [f"- {part.name}: {one.what} — {one.repeat}" for part in parts for one in part.faults]
    rows = [
        [
            part.name,
            f"{part.tries:,}" + (f" of {part.possible:,}" if part.possible else ""),
            str(len(part.faults)),
            part.note,
        ]
        for part in parts
    ]
    table = markdown_table(("what", "tries", "faults", "figures"), rows)
    return "\n".join([*lines, *([""] if lines else []), table])
