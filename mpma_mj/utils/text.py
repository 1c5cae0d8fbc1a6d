"""Text for people: printable names, options as they are typed, near matches, lists, tables."""

from __future__ import annotations

import difflib
import os
import shlex
from collections.abc import Iterable, Sequence

from mpma_mj.errors import printable

__all__ = [
    "as_flag",
    "did_you_mean",
    "field_name",
    "listing",
    "markdown_table",
    "option_name",
    "printable",
    "shell_word",
]

_SIMILARITY = 0.7  # of names, from 0 to 1 (choice)
_FLAGS = {"start": "from", "end": "to"}  # `from` is a keyword of Python
_FIELDS = {flag: field for field, flag in _FLAGS.items()}


def option_name(field: str) -> str:
    """Return what the command line calls an option."""
    return _FLAGS.get(field, field.replace("_", "-"))


def field_name(option: str) -> str:
    """Return what Python calls an option of the command line."""
    return _FIELDS.get(option, option.replace("-", "_"))


def as_flag(option: str, value: str | None) -> str:
    """Return an option as it is typed."""
    flag = f"--{option_name(option)}"
    return flag if value is None else f"{flag} {value}"


def shell_word(path: object) -> str:
    """Return a path as a word of a shell: quoted if need be, no option, and printable."""
    word = str(path)
    if word.startswith("-"):
        word = f"./{word}"
    if printable(word) == word:
        return shlex.quote(word)
    return f"$'{''.join(map(_in_shell, word))}'"


def _in_shell(character: str) -> str:
    """Return a character as Bash and Zsh read it between $' and '."""
    if printable(character) != character:
        return "".join(f"\\x{byte:02x}" for byte in os.fsencode(character))
    return f"\\{character}" if character in "\\'" else character


def did_you_mean(name: str, known: Iterable[str], form: str = "{}") -> str:
    """Return a question with the only name that has the word, or a similar one; or "".

    Args:
        name: Unknown name.
        known: Known names.
        form: How the name is written in the question: `"{{{}}}"` for an option of a remedy.
    """
    names = list(known)
    near = [one for one in names if f"_{name}" in f"_{one}"]  # where a word begins
    if len(near) != 1:
        near = difflib.get_close_matches(name, names, n=1, cutoff=_SIMILARITY)
    return f"did you mean {form.format(near[0])}?" if near else ""


def listing(items: Sequence[object], most: int) -> str:
    """Return a list of items in words, such as "a, b and 3 more".

    Args:
        items: What is listed.
        most: Number of items that are written out.
    """
    shown = ", ".join(map(str, items[:most]))
    return f"{shown} and {len(items) - most} more" if len(items) > most else shown


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown.

    Args:
        head: Cells of the header.
        rows: Cells of each row.
    """
    lines = [f"| {' | '.join(line)} |" for line in (head, *rows)]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])
