"""Errors of the parser of the command line, each as one line."""

from __future__ import annotations

import re

__all__ = ["parser_error"]

_RULE = re.compile(r"[─-]{8,}")

# What the parser reports, and what is printed in its place; `{command}` is the command.
_REWORDED = {
    r"Error parsing (.+?): invalid literal for int\(\) with base 10: (.+)": (
        "{0} is {1}; expected an integer"
    ),
    r"Error parsing (.+?): could not convert string to float: (.+)": (
        "{0} is {1}; expected a number"
    ),
    r"Error parsing (.+?): no type matching .+? could be instantiated from \[\]": (
        "{0} has no value; expected two numbers"
    ),
    r"Error parsing (.+?): (?:no type .+? from|Could not parse arguments) \[(.+?)\]": (
        "{0} is {1}; expected two numbers"
    ),
    r"Error parsing (.+?): Failed to parse key-value pairs": (
        "{0} has a name without a number; give them by turns"
    ),
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
    r"Missing from .+?: (\S+)": "{0} is missing; {command} --help shows what is needed",
    r"Unrecognized options: (--?[^\s,=]+)[^\n]*\nPerhaps you meant: (--[\w-]+)": (
        "{command} has no option {0}; did you mean {1}?"
    ),
    r"Unrecognized options: (-[^\s,=]+)": "{command} has no option {0}; {command} --help lists all",
    r"Unrecognized options: ([^\n,]+)": "{command} has no use for '{0}'; leave it out",
}


def parser_error(box: str, command: str) -> str:
    """Return an error of the parser on one line, in the words of other errors.

    Args:
        box: Error as the parser prints it: a frame around sections, with rules between them.
        command: Words of the command, for the message.
    """
    lines = " ".join(line.strip(" │╭╮╰╯") for line in box.splitlines())
    sections = [" ".join(section.split()) for section in _RULE.split(lines)]
    text = "\n".join(section for section in sections if section)
    for pattern, reworded in _REWORDED.items():
        found = re.search(pattern, text)
        if found:
            # Several values are listed without the quotes of Python.
            groups = [g.replace("'", "") if "', '" in g else g for g in found.groups()]
            return reworded.format(*groups, command=command)
    return text.replace("\n", "; ")
