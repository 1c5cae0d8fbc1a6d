"""Specification of a sweep: the runs that it trains."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from mpma_mj.errors import BadOptionError
from mpma_mj.training.config import RunConfig

__all__ = ["SweepSpec", "by_point", "seeds", "without_seed"]


@dataclass(frozen=True)
class SweepSpec:
    """Runs of a sweep, each identified by its config.

    Attributes:
        configs: Config of each run, no two equal.
        epochs: Largest number of epochs of a run.
        stop: Whether a run ends when it has converged.

    Raises:
        BadOptionError: There is no run or no epoch, or a run is requested twice.
    """

    configs: tuple[RunConfig, ...]
    epochs: int
    stop: bool = True

    def __post_init__(self) -> None:
        """Check the numbers of runs and epochs, and that runs are distinct."""
        if not self.configs:
            raise BadOptionError("no runs are requested; expected at least 1")
        if self.epochs < 1:
            raise BadOptionError(option="epochs", value=self.epochs, expected="at least 1")
        if len(set(self.configs)) < len(self.configs):
            raise BadOptionError("the same run is requested twice; leave one out")

    @property
    def varying(self) -> tuple[str, ...]:
        """Names of the options in which the runs differ, without the seed."""
        options = [config.options() for config in self.configs]
        names = dict.fromkeys(name for own in options for name in own if name != "seed")
        return tuple(
            name
            for name in names
            # An option that only some agents have varies together with the agent's name.
            if len({str(own[name]) for own in options if name in own}) > 1
        )


def seeds(point: RunConfig, runs: int) -> list[RunConfig]:
    """Return runs of a point of the grid, with its seed and those that follow.

    Raises:
        BadOptionError: The number of runs is less than one.
    """
    if runs < 1:
        raise BadOptionError(option="runs", value=runs, expected="at least 1")
    return [dataclasses.replace(point, seed=point.seed + number) for number in range(runs)]


def without_seed(config: RunConfig) -> RunConfig:
    """Return a config with seed 0, which is equal for runs that differ in their seed only."""
    return dataclasses.replace(config, seed=0)


def by_point(configs: Sequence[RunConfig]) -> dict[RunConfig, list[RunConfig]]:
    """Group runs that differ in their seed only, in the order of the first of each."""
    points: dict[RunConfig, list[RunConfig]] = {}
    for config in configs:
        points.setdefault(without_seed(config), []).append(config)
    return points
