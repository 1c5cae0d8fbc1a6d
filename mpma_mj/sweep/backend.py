"""Who trains: what the engine asks of processes here and of a cluster alike."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Protocol

from mpma_mj.errors import BadOptionError
from mpma_mj.options import BackendName

if TYPE_CHECKING:
    from mpma_mj.sweep.work import Done, Job

__all__ = ["Backend", "open_backend"]


class Backend(Protocol):
    """A number of workers that take one job at a time each.

    Attributes:
        workers: Their number.
    """

    workers: int

    def submit(self, job: Job) -> None:
        """Give a job to a worker that has none; there has to be one."""

    def next_done(self) -> tuple[Job, Done | None]:
        """Wait for a job to end.

        Returns:
            The job and what came of it; None if its worker died.

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
        raise BadOptionError(f"workers is {workers}; expected at least 1")
    if name == "ray":
        from mpma_mj.sweep.cluster import Cluster

        return Cluster(workers, address)
    if address is not None:
        raise BadOptionError("--address is of a Ray cluster; add --backend ray, or drop it")
    from mpma_mj.sweep.processes import Processes

    return Processes(workers)
