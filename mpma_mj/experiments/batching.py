"""Batches of runs that differ in their seeds only and are trained together in one process."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

from mpma_mj.errors import BadOptionError
from mpma_mj.training.config import RunConfig

__all__ = ["cost", "cut", "pieces", "seeds", "shares", "without_seed"]

Batch = tuple[RunConfig, ...]

_LARGEST = 20  # runs of a batch; more save no more time (choice)
_MEMORY = 1e9  # bytes of a batch's Gram matrices of the readouts, at most (choice)
_INPUTS = 40  # features of a readout that are not its nodes, about
_PLENTY = 4  # groups for each worker that keep all busy to the end (choice)


def seeds(point: RunConfig, runs: int) -> list[RunConfig]:
    """Return the config of each run of a point: its own seed and those that follow.

    Raises:
        BadOptionError: The number of runs is less than one.
    """
    if runs < 1:
        raise BadOptionError(option="runs", value=runs, expected="at least 1")
    return [dataclasses.replace(point, seed=point.seed + number) for number in range(runs)]


def without_seed(config: RunConfig) -> RunConfig:
    """Return a config with seed 0, which is equal for runs that differ in their seed only."""
    return dataclasses.replace(config, seed=0)


def shares(groups: int, workers: int) -> int:
    """Return into how many pieces a group is cut, so that no worker is idle at the end."""
    return workers if groups < _PLENTY * workers else 1


def pieces(group: Sequence[RunConfig], count: int) -> list[Batch]:
    """Cut runs that differ in their seeds only into batches of about the same size.

    Args:
        group: Config of each run.
        count: Number of batches; more if one would be too large for its memory, fewer if there
            are fewer runs.
    """
    if not group:
        return []
    count = min(max(count, math.ceil(len(group) / _largest(group[0]))), len(group))
    ends = [round(len(group) * piece / count) for piece in range(count + 1)]
    return [tuple(group[start:end]) for start, end in itertools.pairwise(ends)]


def cut(configs: Sequence[RunConfig], workers: int) -> list[Batch]:
    """Return batches of runs that differ in their seed only, those that take longest first.

    Args:
        configs: Config of each run.
        workers: Number of batches that are trained in parallel.
    """
    groups: dict[RunConfig, list[RunConfig]] = {}
    for config in configs:
        groups.setdefault(without_seed(config), []).append(config)
    count = shares(len(groups), workers)
    batches = [batch for group in groups.values() for batch in pieces(group, count)]
    return sorted(batches, key=cost, reverse=True)


def cost(batch: Sequence[RunConfig]) -> int:
    """Return about how long a batch takes, in arbitrary units."""
    return len(batch) * math.prod(_size(batch[0]))


def _largest(config: RunConfig) -> int:
    """Return the largest number of runs of a batch."""
    modules, nodes = _size(config)
    bytes_of_a_run = 3 * modules * (nodes + _INPUTS) ** 2 * 8
    return max(1, min(_LARGEST, int(_MEMORY / bytes_of_a_run)))


def _size(config: RunConfig) -> tuple[int, int]:
    """Return modules and nodes of a run's agent, 1 for a number that it does not have."""
    options = config.options()
    return options.get("modules", 1), options.get("nodes", 1)
