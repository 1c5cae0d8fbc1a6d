"""Workers: what they do, who they are, and processes of this machine that do it."""

from __future__ import annotations

import abc
import contextlib
import dataclasses
import multiprocessing
import os
import pickle
import signal
import sys
import tempfile
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import connection, forkserver, resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from mpma_mj.errors import BadOptionError, MpmaError
from mpma_mj.options import BackendName
from mpma_mj.utils.system import processors

__all__ = ["Backend", "Processes", "Work", "get_done", "open_backend"]

_MAX_ATTEMPTS = 3  # of work whose worker dies (choice)

# A forked server forks them: as fast as to fork this process, and safe whatever threads it has.
_METHODS = ("forkserver", "spawn")
_SOCKET_NAME = len("/pymp-01234567/listener-01234567")  # of the server, below the temporary folder
_LONGEST_NAME = 103  # bytes of a socket, on macOS; Linux has 107
# What the server imports once for all workers: what trains, and what each `__main__` imports.
_PRELOADED = ["mpma_mj.training.trainer", "mpma_mj.experiments.training", "mpma_mj.commands"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Work(abc.ABC):
    """What is sent to a worker; what it returns is sent back.

    Attributes:
        attempts: How often it was begun, this time included.
    """

    attempts: int = 1

    @abc.abstractmethod
    def do(self) -> Any:
        """Do it and return the result.

        Raises:
            MpmaError: It cannot be done.
        """


W = TypeVar("W", bound=Work)


class Backend(Protocol):
    """A number of workers that take one piece of work at a time each.

    Attributes:
        workers: Their number.
    """

    workers: int

    def submit(self, work: Any) -> None:
        """Give work to a worker that has none; there has to be one."""

    def next_done(self) -> tuple[Any, Any]:
        """Wait for a piece of work to end.

        Returns:
            The work and its result; None if its worker died.

        Raises:
            MpmaError: The worker raised it.
        """


def open_backend(
    name: BackendName, workers: int | None, address: str | None
) -> contextlib.AbstractContextManager[Backend]:
    """Return a backend that is ready as soon as its context is entered, and leaves nothing.

    Args:
        name: Kind of backend.
        workers: Number of workers; as many as there are processors if not given.
        address: HOST:PORT of a Ray cluster; a local one if not given.

    Raises:
        BadOptionError: The number of workers is less than one, or only Ray has addresses.
    """
    if workers is not None and workers < 1:
        raise BadOptionError(option="workers", value=workers, expected="at least 1")
    if name == "ray":
        from mpma_mj.experiments.cluster import Cluster

        return Cluster(workers, address)
    if address is not None:
        raise BadOptionError(
            "an address is of a Ray cluster", remedy="add {backend=ray}, or leave {address} out"
        )
    return Processes(workers)


def get_done(works: Sequence[W], backend: Backend) -> Iterator[tuple[W, Any]]:
    """Yield each piece of work when it is done, with its result.

    Args:
        works: All that is to be done, what takes longest first.
        backend: Who does it.

    Yields:
        The work and its result; None if its worker died as often as it may.

    Raises:
        MpmaError: A worker raised it.
    """
    waiting, working = deque(works), 0
    while waiting or working:
        while waiting and working < backend.workers:
            backend.submit(waiting.popleft())
            working += 1
        work, done = backend.next_done()
        working -= 1
        if done is None and work.attempts < _MAX_ATTEMPTS:
            waiting.append(dataclasses.replace(work, attempts=work.attempts + 1))
        else:
            yield work, done


class Processes:
    """A backend of processes, each with a pipe of its own.

    One killed worker fails all work of an executor of `concurrent.futures` or `loky`, so that the
    job that has to be repeated is not known; and executors of `concurrent.futures` wait for running
    work at the end, and leave their workers when this process is killed.

    Attributes:
        workers: Number of processes.
    """

    def __init__(self, workers: int | None) -> None:
        """Make ready for as many processes as given, or as there are processors."""
        self.workers = workers or processors()
        available = multiprocessing.get_all_start_methods()
        if len(os.fsencode(tempfile.gettempdir())) + _SOCKET_NAME > _LONGEST_NAME:
            available = ["spawn"]  # which needs no socket
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
        """End the processes, also those that work."""
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

    It has to find the modules that this process finds. Python 3.11 passes it `sys.path`, which it
    ignores; so it gets that from the environment. Ctrl-C reaches only this process, which ends it.
    """
    name, before = "PYTHONPATH", os.environ.get("PYTHONPATH")
    os.environ[name] = os.pathsep.join(path or str(Path.cwd()) for path in sys.path)
    resource_tracker.ensure_running()  # which unblocks the signal when it starts
    unblocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # the server inherits it
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, unblocked)
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


class _Worker:
    """A process that does one piece of work after the other, until its pipe is closed.

    Attributes:
        pipe: Source of its answers.
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
    """Work until the pipe is closed, because the requesting process has ended or was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all; the command ends the others
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            pipe.send(_answer(pipe.recv_bytes()))


def _answer(pickled: bytes) -> Any:
    try:
        return pickle.loads(pickled).do()  # here, so that errors of an import are sent back, too
    except MpmaError as error:
        return error
    except Exception as error:
        error.add_note(traceback.format_exc())  # what is sent has no traceback of its own
        return error
