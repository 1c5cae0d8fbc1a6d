"""How runs are shared out: batches that train side by side in one process."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from mpma_mj.experiments.spec import by_point
from mpma_mj.training.config import RunConfig

__all__ = ["cut"]

Batch = tuple[RunConfig, ...]

_LARGEST = 20  # runs of a batch; what side by side saves is had by then (choice)
_MEMORY = 1e9  # most bytes that a batch remembers in the readouts' Gram matrices (choice)
_INPUTS = 40  # features of a readout beside its nodes, about
_PLENTY = 4  # points of a grid for each worker that keep all busy to the end (choice)


def cut(configs: Sequence[RunConfig], workers: int) -> list[Batch]:
    """Return batches of runs that differ in their seed only, those that take longest first.

    With few points of the grid, every worker gets a share of each point, so that none is idle.
    Batches of large networks are small, which limits their memory.

    Args:
        configs: Config of each run.
        workers: Number of batches that are trained in parallel.
    """
    groups = by_point(configs).values()
    shares = workers if len(groups) < _PLENTY * workers else 1
    batches = [
        batch
        for group in groups
        for batch in _pieces(group, max(shares, math.ceil(len(group) / _largest(group[0]))))
    ]
    return sorted(batches, key=_work, reverse=True)


def _pieces(group: Sequence[RunConfig], count: int) -> list[Batch]:
    """Cut a group into pieces whose sizes differ by one at most; none is empty."""
    count = min(count, len(group))
    ends = [round(len(group) * piece / count) for piece in range(count + 1)]
    return [tuple(group[start:end]) for start, end in itertools.pairwise(ends)]


def _largest(config: RunConfig) -> int:
    """Return how many runs a batch may have."""
    modules, nodes = _size(config)
    bytes_of_a_run = 3 * modules * (nodes + _INPUTS) ** 2 * 8
    return max(1, min(_LARGEST, int(_MEMORY / bytes_of_a_run)))


def _work(batch: Batch) -> int:
    return len(batch) * math.prod(_size(batch[0]))


def _size(config: RunConfig) -> tuple[int, int]:
    """Return modules and nodes of a run's agent, 1 for a number that it does not have."""
    options = config.options()
    return options.get("modules", 1), options.get("nodes", 1)
