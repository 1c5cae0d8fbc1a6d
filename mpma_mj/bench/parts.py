"""What can be timed in seconds, by name."""

from __future__ import annotations

from collections.abc import Callable

from mpma_mj.bench import agent, drawing, environment, peers, programs
from mpma_mj.bench.report import Report
from mpma_mj.bench.timing import Progress

__all__ = ["PARTS"]

PARTS: dict[str, Callable[[Progress], Report]] = {
    "env": environment.measure,
    "agent": agent.measure,
    "video": drawing.measure,
    "programs": programs.measure,
    "peers": peers.measure,
}
