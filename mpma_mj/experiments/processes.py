"""Workers that are processes of this machine."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import traceback
from multiprocessing import connection, forkserver
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from mpma_mj.errors import MpmaError
from mpma_mj.experiments.backend import Work
from mpma_mj.utils.system import processors

__all__ = ["Processes"]

# A forked server forks them: as fast as to fork this process, and safe whatever threads it has.
_METHODS = ("forkserver", "spawn")
# What the server imports once for all workers: the work, and what each one's `__main__` imports.
_PRELOADED = ["mpma_mj.experiments.job", "mpma_mj.commands"]


class Processes:
    """A backend of processes, each with a pipe of its own.

    `concurrent.futures` has the same, but does not say whose worker died, leaves workers behind
    when this process is killed, and waits for their work when it wants to end.

    Attributes:
        workers: Number of processes.
    """

    def __init__(self, workers: int | None) -> None:
        """Make ready for as many processes as given, or as there are processors."""
        self.workers = workers or processors()
        available = multiprocessing.get_all_start_methods()
        self._context = multiprocessing.get_context(next(m for m in _METHODS if m in available))
        if self._context.get_start_method() == "forkserver":
            self._context.set_forkserver_preload(_PRELOADED)
            _start_server()
        self._idle: list[_Worker] = []
        self._busy: dict[Any, tuple[_Worker, Work]] = {}  # by the pipe of the worker

    def __enter__(self) -> Self:
        """Return the backend."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes, whatever they are at."""
        for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
            worker.end()

    def submit(self, work: Work) -> None:
        """Give work to an idle process, or to a new one."""
        worker = self._idle.pop() if self._idle else _Worker(self._context)
        worker.send(work)
        self._busy[worker.pipe] = worker, work

    def next_done(self) -> tuple[Work, Any]:
        """Wait for a process to be done with its work, or dead; see `Backend`."""
        worker, work = self._busy.pop(connection.wait(list(self._busy))[0])
        try:
            answer = worker.pipe.recv()
        except (EOFError, OSError):
            worker.end()
            return work, None
        self._idle.append(worker)
        if isinstance(answer, BaseException):
            raise answer
        return work, answer


def _start_server() -> None:
    """Start the process that forks workers; it imports while this one imports something else.

    It has to find the modules that this process finds. Python 3.11 hands it `sys.path`, which it
    does not look at; so it comes by the environment.
    """
    name, before = "PYTHONPATH", os.environ.get("PYTHONPATH")
    os.environ[name] = os.pathsep.join(path or str(Path.cwd()) for path in sys.path)
    try:
        forkserver.ensure_running()
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


class _Worker:
    """A process that does one piece of work after the other, until its pipe is closed.

    Attributes:
        pipe: Where its answers come from.
    """

    def __init__(self, context: Any) -> None:
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()  # else it would not show when the process dies

    def send(self, work: Work) -> None:
        with contextlib.suppress(BrokenPipeError):  # it is dead, which shows when it is to answer
            self.pipe.send(work)

    def end(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(pipe: Connection) -> None:
    """Work until nobody asks any more, because the asking process has ended or was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all; who asks ends the others
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            pipe.send(_answer(pipe.recv()))


def _answer(work: Work) -> Any:
    try:
        return work.do()
    except MpmaError as error:
        return error
    except Exception as error:
        error.add_note(traceback.format_exc())  # what is sent has no traceback of its own
        return error
