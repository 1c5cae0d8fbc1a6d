"""The machine that this runs on."""

from __future__ import annotations

import os
import sys
from pathlib import Path

__all__ = ["peak_memory", "processors"]


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def peak_memory() -> int:
    """Return the most memory that this process has had resident, bytes.

    Where Linux tells it of this program alone that is taken: what `getrusage` says begins with
    what the process had that started it.
    """
    status = Path("/proc/self/status")
    if status.exists():
        lines = dict(line.split(":", 1) for line in status.read_text("ascii").splitlines())
        return 1024 * int(lines["VmHWM"].split()[0])
    import resource  # not there on Windows

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
