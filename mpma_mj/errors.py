"""Errors and warnings that a user can mend.

Each message is one line: what is wrong and where (file, row, joint, option), what was expected,
and how to mend it. Options are named by data, not by text, so that the same error reads
`max_gap=0.5` in Python and `--max-gap 0.5` on the command line. `exit_code` is what the command
line returns: 2 for bad input, 1 for a run that failed.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable
from typing import Any, Self

__all__ = [
    "BadOptionError",
    "CheckpointError",
    "DivergedError",
    "InfeasibleMotionError",
    "MotionFileError",
    "MpmaError",
    "OptionWarning",
    "RecordingWarning",
    "RenderingError",
    "RobotLogError",
    "RunFolderError",
    "StateError",
    "UnknownMotionError",
    "VideoError",
    "WorkerError",
    "WriteOption",
    "as_keyword",
    "one_line",
    "placeholder",
    "printable",
]

WriteOption = Callable[[str, str | None], str]
"""Writer of an option: takes its name in Python, and a value or None."""

# Control characters, such as ESC; those that end a line or turn its direction; and lone surrogates,
# which stand for bytes of a file's name that are not UTF-8 and cannot be drawn or encoded.
_UNPRINTABLE = re.compile(
    r"[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\u200e\u200f\ud800-\udfff]"
)
_LONGEST = 300  # characters of a value (choice)
_OPTION = re.compile(r"\{(\w+)(?:=((?:[^{}]|\{\{|\}\})*))?\}")


def as_keyword(option: str, value: str | None) -> str:
    """Return an option as it is written in Python."""
    return option if value is None else f"{option}={value}"


def placeholder(option: str, value: object) -> str:
    """Return what stands for an option and its value in a remedy, whatever the value holds."""
    doubled = str(value).replace("{", "{{").replace("}", "}}")
    return f"{{{option}={doubled}}}"


def one_line(error: object) -> str:
    """Return what a foreign library says, which may be several lines, on one."""
    return printable(" ".join(str(error).split()))


def printable(name: str) -> str:
    r"""Return a name with escapes, such as \n or \udcff, for characters that cannot be printed."""
    return _UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode(), name)


class _Mendable:
    """A problem and its remedy, which names options in the reader's language.

    Attributes:
        remedy: How to mend it; `{name}` and `{name=value}` stand for options.
        context: Prefix that names what the problem is about; empty where the message names it.
    """

    args: tuple[Any, ...]

    def __init__(self, message: str = "", *, remedy: str = "") -> None:
        """Take what is wrong, perhaps with a remedy that names no option, and the remedy."""
        super().__init__(message)  # type: ignore[call-arg]  # that of an exception
        self.remedy = remedy
        self.context = ""

    def __str__(self) -> str:
        """Return the message with options as keywords of Python."""
        return self.describe(as_keyword)

    def describe(self, write: WriteOption) -> str:
        """Return the message on one line, with options in the reader's language.

        Args:
            write: Writes the name of an option, with a value or without.
        """

        def written(found: re.Match[str]) -> str:
            value = found[2]
            if value is not None:
                value = value.replace("{{", "{").replace("}}", "}")
            return write(found[1], value)

        remedy = _OPTION.sub(written, self.remedy)
        parts = (part for part in (self._problem(write), remedy) if part)
        return printable(self.context + "; ".join(parts))

    def with_context(self, context: object) -> Self:
        """Return the same message with what it is about in front, its options being kept."""
        found = copy.copy(self)
        found.context = f"{context}: {self.context}"
        return found

    def _problem(self, write: WriteOption) -> str:
        """Return what is wrong."""
        return str(self.args[0])


class MpmaError(_Mendable, Exception):
    """Base of all errors that this package raises on purpose."""

    exit_code = 2


class BadOptionError(MpmaError, ValueError):
    """An option or argument is out of bounds, or contradicts another.

    Attributes:
        option: Name of the option in Python; the message, if any, then says what is wrong with it.
        value: Value that was given.
        expected: What was expected instead.
    """

    def __init__(
        self,
        message: str = "",
        *,
        option: str = "",
        value: Any = None,
        expected: str = "",
        remedy: str = "",
    ) -> None:
        """Take the problem as text, as an option's value, or as an option and what it has."""
        super().__init__(message, remedy=remedy)
        self.option, self.value, self.expected = option, value, expected

    def _problem(self, write: WriteOption) -> str:
        if not self.option:
            return super()._problem(write)
        if message := super()._problem(write):
            return f"{write(self.option, None)} {message}"
        typed = isinstance(self.value, tuple) and write is not as_keyword
        value = " ".join(map(str, self.value)) if typed else repr(self.value)
        value = value if len(value) <= _LONGEST else f"{value[:_LONGEST]}…"
        problem = f"{write(self.option, None)} is {value}"
        return f"{problem}; expected {self.expected}" if self.expected else problem


class StateError(MpmaError, RuntimeError):
    """A method was called in the wrong order, such as `learn` before an episode."""


class UnknownMotionError(MpmaError):
    """Neither a built-in motion nor a file that exists."""


class MotionFileError(MpmaError):
    """A recording cannot be read, or not as the motion of two arms."""


class InfeasibleMotionError(MpmaError):
    """A motion demands more speed or bend than the arms have."""


class RobotLogError(MpmaError):
    """A robot's log cannot be read, or does not show what is to be identified."""


class RunFolderError(MpmaError):
    """A run folder cannot be written, or must not be overwritten."""


class CheckpointError(MpmaError):
    """A checkpoint is damaged, or belongs to something else."""


class DivergedError(MpmaError):
    """A simulation no longer holds finite numbers."""

    exit_code = 1


class RenderingError(MpmaError):
    """No OpenGL backend can draw."""

    exit_code = 1


class VideoError(MpmaError):
    """A video cannot be encoded."""

    exit_code = 1


class WorkerError(MpmaError):
    """Processes that train runs died, or run another version of the package."""

    exit_code = 1


class OptionWarning(_Mendable, UserWarning):
    """Options lead to a poor result; the message says why."""


class RecordingWarning(_Mendable, UserWarning):
    """A property of a recording may be wrong; the message names what was used instead."""
