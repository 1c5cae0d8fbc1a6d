"""Workers that are processes of a Ray cluster."""

from __future__ import annotations

import contextlib
import logging
import re
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Self

from mpma_mj.errors import BadOptionError, WorkerError, one_line
from mpma_mj.experiments.backend import Work
from mpma_mj.training.config import versions
from mpma_mj.utils.system import processors

__all__ = ["Cluster"]

_PATIENCE = 10.0  # s until an address counts as not answering
_LOOK = 1.0  # s between two looks at the head
_REFUSALS = 5  # in a row, after which it is gone (choice)
_QUIET = {"log_to_driver": False, "logging_level": logging.ERROR}
# Ends at once: leaving the cluster would take seconds.
_CONNECT = "import os, ray, sys; ray.init(address=sys.argv[1], log_to_driver=False); os._exit(0)"


class Cluster:
    """A backend of Ray's; results return here, so that nodes need no common disk.

    Attributes:
        workers: Number of jobs at a time.
    """

    def __init__(self, workers: int | None, address: str | None) -> None:
        """Connect to a cluster, or start one on this machine.

        Args:
            workers: Number of workers; as many as the cluster has processors if not given.
            address: HOST:PORT of the cluster's head, or "auto" for the one of this machine;
                a new one that ends with the command if not given.

        Raises:
            BadOptionError: Ray is not installed, or no cluster answers.
        """
        try:
            import ray
        except ModuleNotFoundError:
            raise BadOptionError(
                "Ray is not installed",
                remedy="{backend=ray} needs it: in a checkout, pip install -e '.[ray]'",
            ) from None
        self._ray: Any = ray
        if address is None:
            here = workers or processors()
            try:
                ray.init(address="local", num_cpus=here, include_dashboard=False, **_QUIET)
            except OSError as error:  # such as a name of a socket that is too long
                raise WorkerError(
                    f"Ray does not start: {one_line(error)}; set TMPDIR to a folder of a short name"
                ) from None
        else:
            _check_answers(address)
            ray.init(address=address, **_QUIET)
        self.workers = workers or max(1, int(ray.cluster_resources().get("CPU", 1)))
        # Ray would try again by itself, without reporting it.
        self._do = ray.remote(num_cpus=1, max_retries=0)(do)
        self._versions = versions()
        self._jobs: dict[Any, Work] = {}
        host, _, port = ray.get_runtime_context().gcs_address.rpartition(":")
        self._head = host, int(port)
        # Ray prints what happens to its nodes, and results are to stand alone.
        self._quiet = contextlib.redirect_stdout(sys.stderr)

    def __enter__(self) -> Self:
        """Return the backend."""
        self._quiet.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the cluster, which ends what still runs there for this command."""
        self._ray.shutdown()
        self._quiet.__exit__(kind, error, trace)

    def submit(self, work: Work) -> None:
        """Give work to the cluster."""
        self._jobs[self._do.remote(work, self._versions)] = work

    def _wait(self) -> Any:
        """Wait for a job to end; Ray itself waits for its head, and then ends this process.

        Raises:
            WorkerError: The cluster's head is gone.
        """
        refused = 0
        while True:
            done, _ = self._ray.wait(list(self._jobs), num_returns=1, timeout=_LOOK)
            if done:
                return done[0]
            try:
                socket.create_connection(self._head, timeout=_PATIENCE).close()
                refused = 0
            except OSError:
                refused += 1
            if refused == _REFUSALS:
                raise WorkerError(
                    f"the head of the Ray cluster, {':'.join(map(str, self._head))}, no longer"
                    " answers; start it again, and give the same command once more: it goes on"
                )

    def next_done(self) -> tuple[Work, Any]:
        """Wait for work to be done or lost; see `Backend`."""
        done = self._wait()
        work = self._jobs.pop(done)
        try:
            return work, self._ray.get(done)
        except self._ray.exceptions.RayTaskError as error:
            cause = error.cause
        except self._ray.exceptions.RayError:  # the process, its node, or its memory is gone
            return work, None
        if "failed to import on the worker" in str(cause):  # as Ray puts it
            raise WorkerError(
                "a node of the cluster cannot import mpma_mj; install the same version on all nodes"
            )
        raise cause


def do(work: Work, expected: Mapping[str, str]) -> Any:
    """Do work on a worker, and return its result; Ray shows the worker by this name.

    Args:
        work: The work.
        expected: Versions of the packages that determine the results, on the requesting machine.

    Raises:
        WorkerError: The worker has another version of a package.
        MpmaError: The work cannot be done.
    """
    here = versions()
    for package, version in expected.items():
        if here[package] != version:
            raise WorkerError(
                f"a worker has {package} {here[package]}, the command {version}; install the same"
                " version on all machines"
            )
    return work.do()


def _check_answers(address: str) -> None:
    """Refuse an address at which no cluster answers, soon.

    Ray's own `init` attempts for minutes, and ends the process when it gives up; so the first
    attempt is made by another process, which can be stopped.

    Raises:
        BadOptionError: There is no such address, or no cluster of this version answers there.
    """
    if not re.fullmatch(r"auto|[^:/]+:\d{1,5}", address):
        expected = "HOST:PORT of a Ray cluster's head"
        raise BadOptionError(option="address", value=address, expected=expected)
    until = time.monotonic() + _PATIENCE
    host, _, port = address.partition(":")
    try:
        if port:
            socket.create_connection((host, int(port)), timeout=_PATIENCE).close()
        subprocess.run(
            [sys.executable, "-c", _CONNECT, address],
            check=True,
            capture_output=True,
            timeout=max(1.0, until - time.monotonic()),
        )
    except subprocess.CalledProcessError as error:
        reason = _last_line(error.stderr)
    except subprocess.TimeoutExpired as error:
        reason = f"within {_PATIENCE:g} s: {_last_line(error.stderr)}"
    except (OSError, OverflowError) as error:
        reason = one_line(error)
    else:
        return
    raise BadOptionError(
        f"address {address}: no Ray cluster answers ({reason}); start one with `ray start --head`,"
        " or correct the address"
    )


def _last_line(output: bytes | None) -> str:
    """Return the last line of Ray's output, without the time and place that it begins with."""
    lines = (output or b"").decode(errors="replace").strip().splitlines() or ["nothing"]
    return re.sub(r"^\[.*?\] (\S+: )?", "", lines[-1])
