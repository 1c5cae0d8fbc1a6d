"""What trials came to, over seeds."""

from __future__ import annotations

import functools
import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from mpma_mj.evaluation.disturbances import DISTURBANCES, Level
from mpma_mj.evaluation.statistics import Interval, interval
from mpma_mj.experiments.robustness import Found

__all__ = ["MEAN", "RECOVERED", "Results", "Tally"]

RECOVERED = 1.0  # p_e under which an agent has learned to cope, percent (choice)
MEAN = "mean"  # level that stands for all dances never seen together


@dataclass(frozen=True)
class Tally:
    """A measure over seeds.

    Attributes:
        mean: Its mean over those that danced to the end, with its interval.
        diverged: How many did not.
        runs: How many there are.
    """

    mean: Interval
    diverged: int
    runs: int

    @property
    def text(self) -> str:
        """The same as a cell of a table."""
        if self.diverged == self.runs:
            return "diverged"
        lost = f" ({self.diverged} of {self.runs} diverged)" if self.diverged else ""
        return self.mean.text(2) + lost


class Results:
    """What all agents found in all trials.

    Attributes:
        found: All of it, in the order of agents, seeds, disturbances and levels.
        agents: Names of the agents.
        levels: Levels of each disturbance, by its name; those that the arms can follow.
        beyond: Levels of each disturbance that they cannot.
        adapts: Epochs of learning on; 0 for none.
    """

    def __init__(self, found: Sequence[Found], agents: Sequence[str], adapts: int) -> None:
        """Put everything in order.

        Args:
            found: What was found, of all agents in the same trials.
            agents: Names of the agents in the order in which they are to be shown.
            adapts: Epochs of learning on; 0 for none.
        """
        order = list(DISTURBANCES)
        self.found = sorted(
            found,
            key=lambda one: (agents.index(one.agent), one.seed, order.index(one.disturbance)),
        )
        self.agents, self.adapts = tuple(agents), adapts
        self.levels: dict[str, list[Level]] = {}
        self.beyond: dict[str, list[Level]] = {}
        for one in self.found:
            can = self.levels.setdefault(one.disturbance, [])
            cannot = self.beyond.setdefault(one.disturbance, [])
            kind = cannot if one.outcome == "beyond the arms" else can
            if one.level not in kind:
                kind.append(one.level)
        for name, levels in self.levels.items():
            if name == "unseen" and len(levels) > 1:
                levels.append(MEAN)

    @property
    def learners(self) -> tuple[str, ...]:
        """Names of the agents that learned on."""
        return tuple(a for a in self.agents if any(f.course for f in self.found if f.agent == a))

    def p_e(self, agent: str, disturbance: str, level: Level) -> Tally:
        """Return p_e without learning."""
        return _tally([one[0] for one in self._seeds(agent, disturbance, level)])

    def p_e_after(self, agent: str, disturbance: str, level: Level) -> Tally:
        """Return p_e after all epochs of learning."""
        return _tally([course[-1] for _, course in self._seeds(agent, disturbance, level)])

    def recovery(self, agent: str, disturbance: str, level: Level) -> list[float]:
        """Return after how many epochs of learning p_e was under 1 %, infinite for never."""
        return [
            next((float(n) for n, p_e in enumerate(course) if p_e < RECOVERED), math.inf)
            for _, course in self._seeds(agent, disturbance, level)
        ]

    def _seeds(
        self, agent: str, disturbance: str, level: Level
    ) -> list[tuple[float, tuple[float, ...]]]:
        """Return p_e and course of each seed; of all levels their mean."""
        if level != MEAN:
            return self._by_name[agent, disturbance, level]
        each = [self._by_name[agent, disturbance, one] for one in self.levels[disturbance][:-1]]
        return [
            (
                statistics.fmean(p_e for p_e, _ in dances),
                tuple(map(statistics.fmean, zip(*(course for _, course in dances), strict=True))),
            )
            for dances in zip(*each, strict=True)
        ]

    @functools.cached_property
    def _by_name(self) -> dict[tuple[str, str, Level], list[tuple[float, tuple[float, ...]]]]:
        named: dict[tuple[str, str, Level], list[tuple[float, tuple[float, ...]]]] = {}
        for one in self.found:
            key = (one.agent, one.disturbance, one.level)
            named.setdefault(key, []).append((one.p_e_percent, one.course))
        return named


def _tally(values: Sequence[float]) -> Tally:
    """Return the tally of a measure of each seed, NaN where it diverged."""
    danced = [value for value in values if not math.isnan(value)]
    return Tally(interval(danced), len(values) - len(danced), len(values))
