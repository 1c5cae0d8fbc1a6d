"""Robustness of trained agents: p_e under disturbances, over seeds."""

from __future__ import annotations

import collections
import functools
import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.disturbances import DISTURBANCES, DisturbanceLevel, Level, shown
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, fine_tune, posture_errors_percent
from mpma_mj.evaluation.statistics import Interval, interval
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.utils.data_files import csv_text
from mpma_mj.utils.text import markdown_table

__all__ = [
    "MEAN",
    "RECOVERED",
    "LevelResult",
    "Robustness",
    "Tally",
    "as_csv",
    "as_markdown",
    "evaluate_levels",
]

Array = NDArray[np.float64]
Outcome = Literal["completed", "diverged"]
Episodes = tuple[float, tuple[float, ...]]  # p_e without learning, and of epochs of fine-tuning

RECOVERED = 1.0
"""p_e below which an agent has recovered, percent (choice)."""

MEAN = "mean"
"""Level that stands for all unseen motions together."""


@dataclass(frozen=True)
class LevelResult:
    """Result of one agent at one level of a disturbance, as JSON can hold it.

    Attributes:
        agent: Name of the agent.
        seed: Seed of the agent.
        disturbance: Name of the disturbance.
        level: The level.
        outcome: Whether the episode without learning was completed.
        p_e_percent: p_e without learning, percent; None without a completed episode.
        fine_tuned: p_e by the number of epochs of fine-tuning before, "0", "1", …, percent; None
            where the simulation diverged. Empty without fine-tuning.
    """

    agent: str
    seed: int
    disturbance: str
    level: Level
    outcome: Outcome
    p_e_percent: float | None
    fine_tuned: Mapping[str, float | None]


def evaluate_levels(
    agent: str,
    trained: TrainedAgents,
    levels: Sequence[DisturbanceLevel],
    epochs: int = 0,
    progress: Callable[[range], Iterable[int]] = lambda numbers: numbers,
) -> list[LevelResult]:
    """Evaluate R agents at levels of disturbances.

    Args:
        agent: Name of the agents.
        trained: The agents.
        levels: The levels.
        epochs: Number of epochs of fine-tuning at each level; 0 for none.
        progress: Wraps the indices of the levels, to show the progress.

    Raises:
        BadOptionError: The agents cannot have an option of a level.
    """
    p_es: dict[EvalCondition, tuple[Array, Array]] = {}
    results = []
    for number in progress(range(len(levels))):
        condition = levels[number].condition
        if condition not in p_es:
            p_es[condition] = _p_e(trained, condition, epochs)
        for row, seed in enumerate(trained.seeds):
            name = (agent, seed, levels[number].disturbance, levels[number].level)
            p_e, course = (_or_none(values[..., row]) for values in p_es[condition])
            outcome: Outcome = "diverged" if p_e[0] is None else "completed"
            fine_tuned = {str(epoch): value for epoch, value in enumerate(course)}
            results.append(LevelResult(*name, outcome, p_e[0], fine_tuned))
    return results


def _p_e(trained: TrainedAgents, condition: EvalCondition, epochs: int) -> tuple[Array, Array]:
    """Return p_e, shape (1, R), and that of each epoch of fine-tuning, shape (E + 1 or 0, R)."""
    try:
        p_e = posture_errors_percent(evaluate(trained, condition))[None]
        # One epoch more, as each is an episode before the agents learn from it.
        return p_e, fine_tune(trained, condition, epochs + 1)[1] if epochs else p_e[:0]
    except BadOptionError as error:
        remedy = "choose other {levels}, or an agent trained with that"
        raise BadOptionError(f"{condition.name}: {error}", remedy=remedy) from None


def _or_none(values: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]


@dataclass(frozen=True)
class Tally:
    """A measure over seeds.

    Attributes:
        mean: Its mean over completed episodes, with its interval.
        diverged: Number of seeds whose simulation diverged.
        runs: Number of seeds.
    """

    mean: Interval
    diverged: int
    runs: int

    @property
    def text(self) -> str:
        """Cell of a table."""
        if self.diverged == self.runs > 0:
            return "diverged"
        lost = f" ({self.diverged} of {self.runs} diverged)" if self.diverged else ""
        return self.mean.text(2) + lost


class Robustness:
    """Results of all agents at all levels.

    Attributes:
        results: The results in the order of agents, seeds, disturbances and levels.
        agents: Names of the agents.
        levels: Levels of each disturbance, by its name.
        epochs: Number of epochs of fine-tuning; 0 for none.
    """

    def __init__(self, results: Sequence[LevelResult], agents: Sequence[str], epochs: int) -> None:
        """Order the results.

        Args:
            results: Results of all agents at the same levels.
            agents: Names of the agents in the order in which they are shown.
            epochs: Number of epochs of fine-tuning; 0 for none.
        """
        order = list(DISTURBANCES)
        self.results = sorted(
            results,
            key=lambda one: (agents.index(one.agent), one.seed, order.index(one.disturbance)),
        )
        self.agents, self.epochs = tuple(agents), epochs
        self.levels: dict[str, list[Level]] = {}
        for one in self.results:
            levels = self.levels.setdefault(one.disturbance, [])
            if one.level not in levels:
                levels.append(one.level)
        if len(self.levels.get("unseen", ())) > 1:
            self.levels["unseen"].append(MEAN)

    @property
    def fine_tuned(self) -> tuple[str, ...]:
        """Names of the agents that were fine-tuned."""
        return tuple(dict.fromkeys(one.agent for one in self.results if one.fine_tuned))

    def p_e(self, agent: str, disturbance: str, level: Level) -> Tally:
        """Return p_e without learning."""
        return _tally([p_e for p_e, _ in self._seeds(agent, disturbance, level)])

    def p_e_after(self, agent: str, disturbance: str, level: Level) -> Tally:
        """Return p_e after all epochs of fine-tuning."""
        return _tally([course[-1] for _, course in self._seeds(agent, disturbance, level)])

    def recovery(self, agent: str, disturbance: str, level: Level) -> list[float]:
        """Return for each seed the epochs of fine-tuning until p_e < 1 %, infinite for never."""
        return [
            next((float(n) for n, p_e in enumerate(course) if p_e < RECOVERED), math.inf)
            for _, course in self._seeds(agent, disturbance, level)
        ]

    def _seeds(self, agent: str, disturbance: str, level: Level) -> list[Episodes]:
        """Return p_e of each seed; of all unseen motions, their mean."""
        if level != MEAN:
            return self._by_name.get((agent, disturbance, level), [])
        levels = self.levels[disturbance][:-1]
        each = [self._by_name.get((agent, disturbance, one), []) for one in levels]
        return [
            (
                statistics.fmean(p_e for p_e, _ in motions),
                tuple(map(statistics.fmean, zip(*(course for _, course in motions), strict=True))),
            )
            for motions in zip(*each, strict=True)
        ]

    @functools.cached_property
    def _by_name(self) -> dict[tuple[str, str, Level], list[Episodes]]:
        named: dict[tuple[str, str, Level], list[Episodes]] = {}
        for one in self.results:
            p_e, *course = (
                math.nan if value is None else value
                for value in (one.p_e_percent, *one.fine_tuned.values())
            )
            key = (one.agent, one.disturbance, one.level)
            named.setdefault(key, []).append((p_e, tuple(course)))
        return named


def _tally(values: Sequence[float]) -> Tally:
    """Return the tally of a measure of each seed, NaN where it diverged."""
    completed = [value for value in values if not math.isnan(value)]
    return Tally(interval(completed), len(values) - len(completed), len(values))


def as_markdown(robustness: Robustness) -> str:
    """Return a table of p_e, and one of fine-tuning if there was any."""
    pairs = {(one.agent, one.seed) for one in robustness.results}
    seeds = max(collections.Counter(agent for agent, _ in pairs).values(), default=0)
    note = "p_e in %, of the actual posture, without learning"
    if seeds > 1:
        note += f"; means over {seeds} seeds with 95 % bootstrap intervals"
    parts = [_table(robustness, robustness.agents, lambda *at: robustness.p_e(*at).text)]
    parts.append(f"{note}.")
    if any(one.outcome == "diverged" for one in robustness.results):
        parts.append("Episodes that diverged count in no mean.")
    if robustness.epochs:
        agents = robustness.fine_tuned
        parts.append(_table(robustness, agents, lambda *at: _recovery(robustness, *at)))
        parts.append(
            f"Epochs of fine-tuning until p_e < {RECOVERED:g} %, median over seeds; number of seeds"
            f" that reached it; p_e after {robustness.epochs}"
            f" epoch{'s' * (robustness.epochs != 1)} of fine-tuning."
        )
        others = [agent for agent in robustness.agents if agent not in agents]
        if others:
            parts.append(f"Not fine-tuned, as they cannot learn on: {', '.join(others)}.")
    return "\n\n".join(parts) + "\n"


def as_csv(robustness: Robustness) -> str:
    """Return a row for each agent, disturbance, level and seed."""
    rows = []
    for one in robustness.results:
        row = vars(one) | {"level": shown(one.level)}
        fine_tuned = row.pop("fine_tuned").items()
        rows.append(row | {f"fine_tuned.{epochs}": p_e for epochs, p_e in fine_tuned})
    return csv_text(rows)


def _table(
    robustness: Robustness, agents: Sequence[str], cell: Callable[[str, str, Level], str]
) -> str:
    """Return a table with a row for each level and a column for each agent."""
    rows = []
    for name, levels in robustness.levels.items():
        title = DISTURBANCES[name].title
        rows += [
            [title, shown(level), *(cell(agent, name, level) for agent in agents)]
            for level in levels
        ]
    return markdown_table(["disturbance", "level", *agents], rows)


def _recovery(robustness: Robustness, agent: str, disturbance: str, level: Level) -> str:
    epochs = robustness.recovery(agent, disturbance, level)
    if not epochs:
        return "–"
    median = statistics.median(epochs)
    first = f"{median:g}" if math.isfinite(median) else f">{robustness.epochs}"
    recovered = sum(map(math.isfinite, epochs))
    after = robustness.p_e_after(agent, disturbance, level).text
    return f"{first}; {recovered} of {len(epochs)}; {after}"
