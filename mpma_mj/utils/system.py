"""Processors and memory of the machine."""

from __future__ import annotations

import os
import sys
from pathlib import Path

__all__ = ["peak_memory", "processors"]


def processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def peak_memory() -> int:
    """Return the peak resident memory of this process, bytes.

    On Linux it is read from /proc, because the peak of `getrusage` includes that of the process
    that started this one.
    """
    status = Path("/proc/self/status")
    if status.exists():
        lines = dict(line.split(":", 1) for line in status.read_text("ascii").splitlines())
        return 1024 * int(lines["VmHWM"].split()[0])
    import resource  # does not exist on Windows

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
