"""Tries that several forks of this process do, until time is up."""

from __future__ import annotations

import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Sequence
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
    pipes = []
    sys.stdout.flush()
    for worker in range(workers):
        reading, writing = os.pipe()
        if os.fork() == 0:
            os.close(reading)
            _work(tries[worker::workers], do, until, writing)
            os._exit(0)
        os.close(writing)
        pipes.append(reading)
    done, faults = 0, []
    for reading in pipes:
        with os.fdopen(reading, encoding="utf-8") as lines:
            for line in lines:
                done += 1
                faults += [Fault(*one) for one in json.loads(line)]
    for _ in pipes:
        os.wait()
    return done, faults


def _work(tries: Sequence[T], do: Try[T], until: float, writing: int) -> None:
    """Do tries, and write the faults of each as a line."""
    with os.fdopen(writing, "w", encoding="utf-8") as lines:
        for one in tries:
            if time.monotonic() > until:
                return
            try:
                faults = do(one)
            except Exception:
                text = traceback.format_exc().strip().splitlines()
                faults = [Fault(f"the campaign's own error: {' | '.join(text[-3:])}", str(one))]
            lines.write(json.dumps(faults) + "\n")
            lines.flush()
