"""Overview of the commands, as `mpma` alone prints it."""

from __future__ import annotations

import textwrap

from mpma_mj.commands import GROUPS

__all__ = ["overview"]

_WIDTH = 88
_MARGIN = " " * 16  # in front of purposes and examples; names of commands stand in it
_HEAD = """\
usage: mpma COMMAND ...

Two simulated arms learn to imitate motion-capture recordings."""
_FOOT = """\
mpma COMMAND --help lists the options of a command; mpma --version prints the version.
mpma --tyro-print-completion bash prints a script for completion by tab; also zsh, fish."""


def overview() -> str:
    """Return all commands by group, each with its purpose and an example."""
    paragraphs = [_HEAD]
    for title, commands in GROUPS.items():
        lines = [title]
        for name, (command, example) in commands.items():
            purpose = str(command.__doc__).splitlines()[0]
            head = f"  {name}".ljust(len(_MARGIN))
            lines += textwrap.wrap(purpose, _WIDTH, initial_indent=head, subsequent_indent=_MARGIN)
            lines.append(f"{_MARGIN}  {example}")
        paragraphs.append("\n".join(lines))
    return "\n\n".join([*paragraphs, _FOOT])
