"""Errors of the parser of the command line, each as one line."""

from __future__ import annotations

import re

from mpma_mj.utils.text import option_name

__all__ = ["parser_error"]

_RULE = re.compile(r"[─-]{8,}")

_NUMBERS = r"Error parsing ([^\s:]+): no type matching {} could be instantiated from \[(.+?)\]"
_SEVERAL = r"Error parsing ([^\s:]+): Could not find valid parse for arguments: \[(.+?)\]"

# What the parser reports, and what is printed in its place; `{command}` is the command, `{name}`
# the same without mpma, `{example}` an example of it, and `{unused}` what to do with another word.
_REWORDED = {
    r"Error parsing ([^\s:]+): invalid literal for int\(\) with base 10: (.+)": (
        "{0} is {1}; expected an integer"
    ),
    r"Error parsing ([^\s:]+): could not convert string to float: (.+)": (
        "{0} is {1}; expected a number"
    ),
    _NUMBERS.format(r"FLOAT\|\{(\w+)\}"): "{0} is {2}; expected a number, or {1}",
    r"Error parsing ([^\s:]+): no type matching .+? could be instantiated from \[\]": (
        "{0} has no value; expected two numbers"
    ),
    _NUMBERS.format("INT"): "{0} is {1}; expected an integer",
    _NUMBERS.format("FLOAT"): "{0} is {1}; expected a number",
    r"Error parsing ([^\s:]+): (?:no type .+? from|Could not parse arguments) \[(.+?)\]": (
        "{0} is {1}; expected two numbers"
    ),
    _SEVERAL + r"\nArgument helptext: \S+ \[INT": "{0} is {1}; expected integers",
    _SEVERAL: "{0} is {1}; expected numbers",
    r"Error parsing ([^\s:]+): Failed to parse key-value pairs": (
        "{0} has a name without a number; give them by turns"
    ),
    r"Error parsing ([^\s:]+): (has .+ range of two.*)": "{0} {1}; put motions before {0}",
    r"Error parsing ([^\s:]+): no value": "{0} has no value; give one",
    r"Error parsing ([^\n]+)": "{0}",
    r"invalid choice (.+) for argument '(.+?)'\. Expected one of \((.+?),?\)\.": (
        "{1} is {0}; expected one of {2}"
    ),
    r"Missing value for argument \W*?(--[\w-]+|\w+)\W+Expected 1 values": (
        "{0} has no value; give one"
    ),
    r"Missing value for argument \W*?(--[\w-]+|\w+)\W+Expected (\d+) values": (
        "{0} takes {1} values"
    ),
    r"Missing from .+?: (--\S+)": "{0} is missing; {command} --help shows what is needed",
    r"Missing from .+?: (\S+)": "no {0} given; try: {example}",
    r"Unrecognized options: (--?[^\s,=]+)[^\n]*\nPerhaps you meant: (?!\1 )(--[\w-]+)": (
        "{name} has no option {0}; did you mean {1}?"
    ),
    r"Unrecognized .*?options: (-[^\s,=]+)": "{name} has no option {0}; {command} --help lists all",
    r"Unrecognized .*?options: ([^\s,]+)": "{name} has no use for '{0}'; {unused}",
}
_COMMAND = re.compile(r"applied to (mpma [^)\n]+)\)|(?:run|run:|see) (mpma [^\n]+?) --help")


def parser_error(box: str, example: str, unused: str = "leave it out") -> str:
    """Return an error of the parser on one line, in the words of other errors.

    Args:
        box: Error as the parser prints it: a frame around sections, with rules between them.
        example: Example of the command.
        unused: What to do with a word for which the command has no use.
    """
    lines = " ".join(line.strip(" │╭╮╰╯") for line in box.splitlines())
    sections = [" ".join(section.strip("─ ").split()) for section in _RULE.split(lines)]
    sections = [section for section in sections if section]
    text = "\n".join(sections)
    named = _COMMAND.search(text)
    command = (named[1] or named[2]) if named else "mpma"
    words = {"command": command, "name": command.removeprefix("mpma ")}
    words |= {"example": example, "unused": unused}
    unknown = re.search(r"Unrecognized .*?options: --([a-z]+)", text)
    if unknown and (flag := option_name(unknown[1])) != unknown[1]:
        return (
            f"{words['name']} has no option --{unknown[1]}, which is --{flag} on the command line"
        )
    for pattern, reworded in _REWORDED.items():
        found = re.search(pattern, text)
        if found:
            # Several values are listed without the quotes of Python.
            groups = [g.replace("'", "") if "', '" in g else g for g in found.groups()]
            if "{example}" in reworded:
                groups = [group.lower().replace("|", " or ") for group in groups]
            return reworded.format(*groups, **words)
    problem = sections[min(1, len(sections) - 1)]  # after the title
    return f"{problem.partition('. ')[0].rstrip('.')}; {command} --help lists all options"
