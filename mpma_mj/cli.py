"""The command `mpma`."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import tyro

from mpma_mj import __version__, commands
from mpma_mj.agents.config import MPMAConfig
from mpma_mj.commands.run_options import config_type
from mpma_mj.errors import BadOptionError, MpmaError, RecordingWarning
from mpma_mj.utils.option_names import as_flag

__all__ = ["main"]

_INTERRUPTED = 130  # what shells expect of a command that was stopped by Ctrl-C
_NO_READER = 141  # and of one whose output nobody reads any more, as in `mpma ... | head -1`


class Command(Protocol):
    """What was typed after `mpma`, its options being fields."""

    def run(self) -> object:
        """Do it and return what is printed last; None for nothing."""


_WITH_AGENT: dict[str, Any] = {
    "imitate": commands.Imitate,
    "sweep": commands.Sweep,
    "grow": commands.Grow,
    "compare": commands.Compare,
}
_COMMANDS: dict[str, Callable[..., Command]] = {
    "imitate": commands.Imitate[MPMAConfig],
    "motion": commands.InspectMotion,
    "render": commands.Render,
    "view": commands.View,
    "table1": commands.Table1,
    "sweep": commands.Sweep[MPMAConfig],
    "benchmark": commands.Benchmark,
    "ablate": commands.Ablate,
    "scale": commands.Scale,
    "bench": commands.Bench,
    "capture": commands.Capture,
    "grow": commands.Grow[MPMAConfig],
    "attractor": commands.Attractor,
    "lesion": commands.Lesion,
    "stress": commands.Stress,
    "compare": commands.Compare[MPMAConfig],
    "identify": commands.Identify,
}


@contextlib.contextmanager
def _whatever_the_encoding() -> Iterator[None]:
    """Let the terminal show a mark for a character that it lacks; then leave it as it was."""
    with contextlib.ExitStack() as stack:
        # On stderr escapes, as Python has it: file names stay told apart in errors.
        for stream, errors in ((sys.stdout, "replace"), (sys.stderr, "backslashreplace")):
            if isinstance(stream, io.TextIOWrapper):  # a notebook's is none, and lacks nothing
                stack.callback(stream.reconfigure, errors=stream.errors)
                stream.reconfigure(errors=errors)
        yield


@_whatever_the_encoding()
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Words after the command's name; those of the process if not given.

    Returns:
        Exit code: 0, 2 for something that the user has to mend, 1 for a run that failed; 130 if
        it was interrupted, 141 if nobody reads its output any more.
    """
    try:
        _run(list(sys.argv[1:] if arguments is None else arguments))
    except MpmaError as error:
        print(f"mpma: {error.describe(as_flag)}", file=sys.stderr)
        return error.exit_code
    except MemoryError:
        print(
            "mpma: not enough memory; take fewer --modules, --nodes, --repeats, or less time",
            file=sys.stderr,
        )
        return 1
    except BrokenPipeError:
        # What is still to be written would be complained about when the interpreter ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _NO_READER
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        print(f"mpma: {place}{error.strerror or error}; check path and rights", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("mpma: interrupted", file=sys.stderr)
        return _INTERRUPTED
    return 0


def _run(words: Sequence[str]) -> None:
    """Do what is asked for and print what is printed last."""
    if words == ["--version"]:
        print(f"mpma {__version__}")
        _flush()
        return
    for word in words:
        if word == "" or (word.startswith("--") and word.endswith("=")):
            raise BadOptionError(f"'{word}' is an empty argument; give it a value, or leave it out")
    command = _parse(words)
    if isinstance(command, commands.Imitate):
        command.check_resumed(words)
    with _warnings_as_lines():
        last = command.run()
    if last is not None:
        print(last)
    _flush()


def _parse(words: Sequence[str]) -> Command:
    """Return the command that was typed; help and errors of the parser end the process.

    Raises:
        MpmaError: The value of an option is refused.
    """
    complaints = io.StringIO()
    try:
        # The parser reports any ValueError of an option as its own, in a box without the reason.
        with contextlib.redirect_stderr(complaints):
            return tyro.extras.subcommand_cli_from_dict(
                _commands(words),
                prog="mpma",
                description="Two simulated arms learn to dance from recordings.",
                args=words,
            )
    except SystemExit as end:
        cause: BaseException | None = end
        while cause is not None and not isinstance(cause, MpmaError):
            cause = cause.__context__
        if cause is not None:
            raise cause from None
        print(complaints.getvalue(), end="", file=sys.stderr)
        raise
    finally:
        _flush()  # the help, after which it ends here


def _commands(words: Sequence[str]) -> dict[str, Callable[..., Command]]:
    """Return the commands; those that take an agent's options have them of the agent named."""
    kind = config_type(words) if words and words[0] in _WITH_AGENT else MPMAConfig
    return _COMMANDS | {name: command[kind] for name, command in _WITH_AGENT.items()}


def _flush() -> None:
    """Write what was printed, so that errors come now and not when the interpreter ends."""
    print(end="", flush=True)


@contextlib.contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Show what may be wrong with a recording as one line each, without where in the code."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        told = message.describe(as_flag) if isinstance(message, RecordingWarning) else message
        print(f"mpma: warning: {told}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("always", RecordingWarning)
        # That a display does not answer; where that matters, an error says so.
        warnings.filterwarnings("ignore", module="glfw")
        warnings.showwarning = show
        yield


if __name__ == "__main__":
    sys.exit(main())
