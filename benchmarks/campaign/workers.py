"""Tries that several forks of this process do, until time is up."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from benchmarks.campaign.faults import Fault

__all__ = ["spread"]

T = TypeVar("T")
Try = Callable[[T], list[Fault]]


def spread(
    tries: Sequence[T], do: Try[T], *, workers: int, seconds: float
) -> tuple[int, list[Fault]]:
    """Do tries in several processes, in their order, until time is up.

    Args:
        tries: What there is to try.
        do: Does one and returns the faults that it shows; an exception is a fault, too.
        workers: Number of processes.
        seconds: After which no further one is begun.

    Returns:
        How many were done, and the faults.
    """
    until = time.monotonic() + seconds
    sys.stdout.flush()
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder, str(worker)) for worker in range(workers)]
        processes = []
        for worker, file in enumerate(files):
            processes.append(os.fork())
            if processes[-1] == 0:
                try:
                    _work(tries[worker::workers], do, until, file)
                finally:
                    os._exit(0)
        for process in processes:
            os.waitpid(process, 0)
        found = [json.loads(line) for file in files for line in file.read_text().splitlines()]
    return len(found), [Fault(*one) for faults in found for one in faults]


def _work(tries: Sequence[T], do: Try[T], until: float, file: Path) -> None:
    """Do tries, and write the faults of each as a line; those that there are also to stderr."""
    with file.open("w", encoding="utf-8") as lines:
        for one in tries:
            if time.monotonic() > until:
                return
            try:
                faults = do(one)
            except Exception:
                text = traceback.format_exc().strip().splitlines()
                faults = [Fault(f"the campaign's own error: {' | '.join(text[-3:])}", str(one))]
            for fault in faults:
                print(f"fault: {fault.what}: {fault.repeat}", file=sys.stderr, flush=True)
            lines.write(json.dumps(faults) + "\n")
            lines.flush()
