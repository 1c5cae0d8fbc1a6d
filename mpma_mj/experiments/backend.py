"""Backends that do work: the interface of local processes and of a cluster."""

from __future__ import annotations

import abc
import contextlib
import dataclasses
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from mpma_mj.errors import BadOptionError
from mpma_mj.options import BackendName

__all__ = ["Backend", "Work", "get_done", "open_backend"]

_MAX_ATTEMPTS = 3  # of work whose worker dies (choice)


@dataclass(frozen=True, eq=False, kw_only=True)
class Work(abc.ABC):
    """What is sent to a worker; what comes of it is sent back.

    Attributes:
        attempts: How often it was begun, this time included.
    """

    attempts: int = 1

    @abc.abstractmethod
    def do(self) -> Any:
        """Do it and return what came of it.

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
            The work and what came of it; None if its worker died.

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
            "an address is of a Ray cluster", remedy="add {backend=ray}, or drop it"
        )
    from mpma_mj.experiments.processes import Processes

    return Processes(workers)


def get_done(works: Sequence[W], backend: Backend) -> Iterator[tuple[W, Any]]:
    """Yield each piece of work when it is done, with what came of it.

    Args:
        works: All that is to be done, what takes longest first.
        backend: Who does it.

    Yields:
        The work and what came of it; None if its worker died as often as it may.

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
