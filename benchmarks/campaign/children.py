"""Commands in forks of this process, which has imported what they need, so that they start at once.

This process draws nothing and starts no thread, so that a fork of it is like a new process.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import resource
import select
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

__all__ = ["Ended", "command", "in_fork", "warm_up"]

_MEMORY = 8 << 30  # bytes of addresses, of which the libraries take a third
_PROGRESS = (
    *("  ", "epoch ", "training", "evaluating", "looking for", "running without", "resuming"),
    *("run: dropping", "other: dropping"),
)
_CRASHED = 70  # exit code of an exception, which a command never has


class Ended(NamedTuple):
    """How a process ended.

    Attributes:
        code: Its exit code; the negative number of the signal that ended it; None if it took too
            long.
        out: What it printed to standard output.
        err: What it printed to standard error.
    """

    code: int | None
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """Lines on standard error but those of progress."""
        lines = self.err.splitlines()
        return [one for one in lines if one.strip() and not one.startswith(_PROGRESS)]

    @property
    def is_refusal(self) -> bool:
        """Whether a command was refused, in one line."""
        left = [one for one in self.lines if not one.startswith("mpma: warning: ")]
        return self.code in (1, 2) and len(left) == 1 and left[0].startswith("mpma: ")

    @property
    def last_line(self) -> str:
        """Last line on standard error."""
        return (self.lines or [""])[-1]


def in_fork(do: Callable[[], int], folder: Path, seconds: float = 60.0) -> Ended:
    """Call a function in a fork of this process, in a folder, and wait until it ends.

    Args:
        do: The function, which returns the exit code.
        folder: Its working directory.
        seconds: After which it is killed.
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        sys.stdout.flush()
        process = os.fork()
        if process == 0:
            _become(do, folder, out.fileno(), err.fileno())
        watched = os.pidfd_open(process)
        in_time = bool(select.select([watched], [], [], seconds)[0])
        os.close(watched)
        with contextlib.suppress(ProcessLookupError):  # with its own children, also those it left
            os.killpg(process, signal.SIGKILL)
        _, status = os.waitpid(process, 0)
        printed = []
        for file in (out, err):
            file.seek(0)
            printed.append(file.read().decode(errors="replace"))
        return Ended(os.waitstatus_to_exitcode(status) if in_time else None, *printed)


def _become(do: Callable[[], int], folder: Path, out: int, err: int) -> None:
    """Do a function as this process, and end it."""
    code: Any = _CRASHED
    try:
        os.setsid()
        os.chdir(folder)
        os.dup2(out, 1)
        os.dup2(err, 2)
        sys.stdout = os.fdopen(1, "w", closefd=False)  # in place of those that pytest may have put
        sys.stderr = os.fdopen(2, "w", closefd=False)
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        code = do()
    except SystemExit as end:
        code = end.code
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 0)


def command(words: Sequence[str]) -> int:
    """Run a command of `mpma`, with workers that are forked, and return its exit code."""
    from mpma_mj.cli import main
    from mpma_mj.experiments import backend

    backend._METHODS = ("fork",)  # else each command imports everything again
    return main(words)


def warm_up(commands: Iterable[str]) -> None:
    """Import what commands import, without running them here."""
    for words in commands:
        with tempfile.TemporaryDirectory() as folder:

            def modules(words: str = words) -> int:
                command(words.split())
                Path("modules.json").write_text(json.dumps(sorted(sys.modules)))
                return 0

            ended = in_fork(modules, Path(folder), seconds=300.0)
            names = Path(folder, "modules.json")
            if not names.exists():
                raise RuntimeError(f"mpma {words} does not work: {ended.err}")
            for name in json.loads(names.read_text()):
                # Some are parts of others that are made while those are imported.
                with contextlib.suppress(ImportError):
                    importlib.import_module(name)
