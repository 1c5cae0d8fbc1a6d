"""All agents in the same environments, side by side in one table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from mpma_mj.agents.registry import agent_class
from mpma_mj.evaluation.statistics import Interval, interval
from mpma_mj.experiments.folder import RunResult
from mpma_mj.experiments.measures import converged, of_point, remarks, values
from mpma_mj.experiments.spec import SweepSpec, by_point, seeds
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.atomic_files import csv_text
from mpma_mj.utils.text import markdown_table, printable

__all__ = ["Line", "as_csv", "as_markdown", "lines", "spec_of", "title"]

# Title, name in a summary, digits after the point.
_COLUMNS = (
    ("p_e, %", "p_e_percent", 2),
    ("feedback ratio", "feedback_ratio", 3),
    ("learned share", "learned_share", 3),
    ("epochs", "epochs", 1),
    ("environment steps", "environment_steps", 0),
    ("nmi", "nmi", 2),
    ("modules used", "modules_used", 1),
)


@dataclass(frozen=True)
class Line:
    """A line of the table: one agent, with one kind of arms, on one movement.

    Attributes:
        point: Settings, without the seed.
        wanted: Number of requested runs.
        runs: The finished runs.
        measures: Means over seeds and their intervals, by name in a summary.
        seconds: How long a run was trained, mean, s; runs side by side, each its equal share.
    """

    point: RunConfig
    wanted: int
    runs: list[RunResult]
    measures: dict[str, Interval]
    seconds: float

    @property
    def motion(self) -> str:
        """The movement, in short."""
        return _short(self.point)


def spec_of(
    bases: Sequence[RunConfig], agents: Sequence[str], runs: int, epochs: int, *, stop: bool
) -> SweepSpec:
    """Return the runs of all agents with both kinds of arms.

    Args:
        bases: All other options, for each motion.
        agents: Names of agents, or paths of their classes.
        runs: Runs of each agent.
        epochs: Most epochs of a run.
        stop: Whether a run ends when it has converged.

    Raises:
        BadOptionError: The number of runs or epochs is less than one, or a movement comes twice.
    """
    points = [
        base.replace(arms=arms, agent=agent)
        for base in bases
        for arms in get_args(Arms)
        for agent in agents
    ]
    return SweepSpec(tuple(run for point in points for run in seeds(point, runs)), epochs, stop)


def title(config: RunConfig) -> str:
    """Return in short what a run is."""
    return f"{_short(config)}, {config.env.arms} arms, {config.agent_name}"


def lines(spec: SweepSpec, runs: Sequence[RunResult]) -> list[Line]:
    """Return the table."""
    table = []
    for point, configs in by_point(spec.configs).items():
        own = of_point(runs, point)
        measures = {name: interval(values(own, name)) for _, name, _ in _COLUMNS}
        seconds = interval([run.seconds for run in own]).mean
        table.append(Line(point, len(configs), own, measures, seconds))
    return table


def as_markdown(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return the table with what has to be said about it."""
    titles = ["motion", "arms", "agent", "converged", *(title for title, _, _ in _COLUMNS)]
    titles.append("seconds a run")
    rows = []
    for line in lines(spec, runs):
        learns = agent_class(line.point.agent_name).trainable
        rows.append(
            [
                *(line.motion, line.point.env.arms, line.point.agent_name),
                f"{converged(line.runs)} of {line.wanted}" if learns else "–",
                *(line.measures[name].text(digits) for _, name, digits in _COLUMNS),
                f"{line.seconds:.2g}" if line.runs else "–",
            ]
        )
    said = (
        "Means over seeds, in brackets their 95 % bootstrap intervals, unless all seeds have the"
        " same. A run's seconds are its share of the time in which one process trained several"
        " runs of the line side by side."
    )
    sentences = [said, *remarks(runs, len(spec.configs))]
    return "\n\n".join([markdown_table(titles, rows), *sentences]) + "\n"


def as_csv(spec: SweepSpec, runs: Sequence[RunResult]) -> str:
    """Return the same with all digits."""
    rows = []
    for line in lines(spec, runs):
        row: dict[str, object] = {
            "motion": line.point.motions[0],
            "arms": line.point.env.arms,
            "agent": line.point.agent_name,
            "converged": converged(line.runs),
            "runs": line.wanted,
        }
        for name, found in line.measures.items():
            row |= found.columns(name)
        rows.append(row | {"seconds_mean": line.seconds})
    return csv_text(rows)


def _short(config: RunConfig) -> str:
    """Return the movement, without the folders on the way to it."""
    return printable(Path(config.motions[0]).name)
