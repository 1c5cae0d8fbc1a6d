"""Entry point of the command line `mpma`."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import logging
import os
import re
import signal
import sys
import textwrap
import threading
import warnings
from collections.abc import Iterator, Sequence
from types import FrameType
from typing import Any, NoReturn, Protocol

import tyro

from mpma_mj import __version__
from mpma_mj.commands import COMMANDS, EXAMPLES, GROUPS
from mpma_mj.commands.analyse import with_analysis
from mpma_mj.commands.parser_errors import parser_error
from mpma_mj.commands.run_options import REFUSED_OPTIONS, config_type, registry, typed_options
from mpma_mj.commands.study import parse_study, remedy_for_unused
from mpma_mj.errors import BadOptionError, MpmaError, OptionWarning, RecordingWarning, one_line
from mpma_mj.utils.text import as_flag, did_you_mean, printable

__all__ = ["main", "overview"]

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


_FILE_LIKE_AN_OPTION = re.compile(r"-[^-\d.][^=]*[./]")  # no option has one dash and such signs
_SOON = 0.05  # s until a lost signal is sent again
_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")  # also in mpma_command.py, which imports nothing
_SIGNALLED = 128  # exit code that shells expect after a signal, less the signal's number
_COMPLETION = {"--tyro-print-completion": 2, "--tyro-write-completion": 3}  # number of words
_NO_READER = 141  # exit code after a closed pipe, as in `mpma ... | head -1`


class Command(Protocol):
    """Command of the command line; its fields are the options."""

    def run(self) -> object:
        """Run the command and return the last line to print, or None."""


@contextlib.contextmanager
def _replace_unencodable() -> Iterator[None]:
    """Replace characters that the terminal cannot encode, until the context ends."""
    with contextlib.ExitStack() as stack:
        # Escapes on stderr, as by default in Python: file names in errors stay distinct.
        for stream, errors in ((sys.stdout, "replace"), (sys.stderr, "backslashreplace")):
            if isinstance(stream, io.TextIOWrapper):  # not in notebooks, which encode everything
                stack.callback(stream.reconfigure, errors=stream.errors)
                stream.reconfigure(errors=errors)
        yield


class _Signalled(KeyboardInterrupt):
    """A signal that ends the process.

    Not KeyboardInterrupt itself: where that passes through code that is executed from text, as
    that of dataclasses is, the interpreter ends by SIGINT although it was caught.
    """


@contextlib.contextmanager
def _signals_interrupt() -> Iterator[list[int]]:
    """Let Ctrl-C, and what ends a process from outside, such as a scheduler, interrupt it.

    Yields:
        Numbers of the signals that were received.
    """
    received: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> None:
        received.append(number)
        raise _Signalled

    # Not where they are ignored, as under nohup, or somebody else handles them.
    usual = (signal.SIG_DFL, signal.default_int_handler)
    numbers = [n for n in signal.Signals if n.name in _ENDING and signal.getsignal(n) in usual]
    if threading.current_thread() is not threading.main_thread():
        numbers = []  # which cannot handle signals
    before = {number: signal.signal(number, interrupt) for number in numbers}
    hook = sys.unraisablehook
    timers: list[threading.Timer] = []

    def send_again(lost: sys.UnraisableHookArgs) -> None:
        """Send a signal again whose exception was lost, as in a callback of a weak reference."""
        if not isinstance(lost.exc_value, _Signalled):
            hook(lost)
            return
        timers.append(threading.Timer(_SOON, os.kill, (os.getpid(), received[-1])))
        timers[-1].start()

    sys.unraisablehook = send_again
    try:
        yield received
    finally:
        sys.unraisablehook = hook
        for timer in timers:  # a signal that is lost at the end came too late
            timer.cancel()
        for number, handler in before.items():
            signal.signal(number, handler)


@_replace_unencodable()
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Words after `mpma`; those of the process if not given.

    Returns:
        Exit code: 0 on success, 2 for bad input, 1 for a run that failed, 130
        after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP, 141 if the output's pipe was closed.
    """
    with _signals_interrupt() as received:
        try:
            return _exit_code(list(sys.argv[1:] if arguments is None else arguments))
        # Code in C that is interrupted may raise another error, as an import does.
        except BaseException as error:
            if not received and not isinstance(error, KeyboardInterrupt):
                raise
        print("mpma: interrupted", file=sys.stderr)
        return _SIGNALLED + next(iter(received), signal.SIGINT)


def _exit_code(words: Sequence[str]) -> int:
    """Run the command, report its error in one line, and return the exit code."""
    try:
        _run(words)
    except MpmaError as error:
        print(f"mpma: {error.describe(as_flag)}", file=sys.stderr)
        return error.exit_code
    except MemoryError:
        print(
            "mpma: not enough memory; give fewer --modules, --nodes or --repeats, or a shorter"
            " motion",
            file=sys.stderr,
        )
        return 1
    except BrokenPipeError:
        # Otherwise the interpreter reports an error for unwritten output when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _NO_READER
    except OSError as error:
        remedy = "; check the path and its permissions" if error.filename else ""
        place = f"{error.filename}: " if error.filename else ""
        is_output = not place and _output_fails()
        if is_output:
            place, remedy = "standard output: ", "; let it go elsewhere"
        problem = printable(f"{place}{error.strerror or error}")
        print(f"mpma: {problem}{remedy}", file=sys.stderr)
        return 1 if is_output else 2
    return 0


def _output_fails() -> bool:
    """Return whether standard output cannot be written, as on a full disk."""
    try:
        _flush()
    except OSError:
        return True
    return False


def _run(words: Sequence[str]) -> None:
    """Parse the words, run the command and print its last line."""
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
    first = words[0] if words else "--help"
    if first in ("--help", "-h", "--version"):
        print(f"mpma {__version__}" if first == "--version" else overview())
        _flush()
        return
    for word in words:
        if word == "" or (word.startswith("--") and word.endswith("=")):
            raise BadOptionError(f"'{word}' is an empty argument; give it a value, or leave it out")
        if _FILE_LIKE_AN_OPTION.match(word):
            raise BadOptionError(f"'{word}' begins like an option; for a file, write ./{word}")
    command = _parse(words)
    if hasattr(command, "given"):
        command = dataclasses.replace(command, given=frozenset(typed_options(words)))
    with _warnings_as_lines():
        last = command.run()
    if last is not None:
        print(printable(str(last)))
    _flush()


def _parse(words: Sequence[str]) -> Any:
    """Return the command that the words describe; help ends the process.

    Raises:
        MpmaError: There is no such command or option, or a value is refused.
    """
    name, *options = words
    if name in _COMPLETION:
        _print_completion(words)
    if name not in COMMANDS:
        remedy = did_you_mean(name, COMMANDS, "mpma {}") or "mpma alone lists all"
        raise BadOptionError(f"no command '{name}'", remedy=remedy)
    parser_errors = io.StringIO()
    try:
        # The parser reports any ValueError of an option in a box without the reason.
        with contextlib.redirect_stderr(parser_errors), registry(REFUSED_OPTIONS):
            if name == "analyse":
                options = with_analysis(options)
            study = parse_study(options) if name == "study" else None
            return study or tyro.cli(_dataclass(name, words), prog=f"mpma {name}", args=options)
    except SystemExit as end:
        cause: BaseException | None = end
        while cause is not None and not isinstance(cause, MpmaError):
            cause = cause.__context__
        if cause is not None:
            raise cause from None
        if end.code:
            unused = remedy_for_unused(options) if name == "study" else "leave it out"
            message = parser_error(parser_errors.getvalue(), EXAMPLES[name], unused)
            raise BadOptionError(message) from None
        raise
    finally:
        _flush()  # help ends the process here


def _print_completion(words: Sequence[str]) -> NoReturn:
    """Print or write a shell's script for completion, which ends the process.

    Raises:
        BadOptionError: The words name no shell, or not the file to write.
    """
    every = {name: _dataclass(name, [name]) for name in COMMANDS}
    with contextlib.suppress(AssertionError), registry(REFUSED_OPTIONS):
        if len(words) == _COMPLETION[words[0]]:
            tyro.extras.subcommand_cli_from_dict(every, prog="mpma", args=words)
    raise BadOptionError(
        f"no completion by '{' '.join(words)}'",
        remedy="try: mpma --tyro-print-completion bash",
    )


def _dataclass(name: str, words: Sequence[str]) -> Any:
    """Return the dataclass of a command, with the options of the agent that the words name."""
    command = COMMANDS[name]
    return command[config_type(words)] if hasattr(command, "__parameters__") else command


def _flush() -> None:
    """Flush standard output, so that errors are raised now and not when the interpreter ends."""
    print(end="", flush=True)


@contextlib.contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Print each warning as one line, without its place in the code."""
    own = OptionWarning, RecordingWarning

    def show(message: Warning | str, *_: object, **__: object) -> None:
        text = message.describe(as_flag) if isinstance(message, own) else one_line(message)
        print(f"mpma: warning: {text}", file=sys.stderr)

    # What other libraries log is nothing that a user could mend.
    logging.disable(logging.WARNING)
    with contextlib.ExitStack() as stack:
        stack.callback(logging.disable, logging.NOTSET)
        stack.enter_context(warnings.catch_warnings())
        for kind in own:
            warnings.simplefilter("always", kind)
        # A display that does not respond; where it is needed, an error is raised.
        warnings.filterwarnings("ignore", module="glfw")
        warnings.showwarning = show
        yield


if __name__ == "__main__":
    sys.exit(main())
