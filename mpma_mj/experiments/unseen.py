"""Study `unseen`: all motions but one are learned together, then that one is imitated."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from mpma_mj.context import equal_segments
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.evaluate import tracking_errors
from mpma_mj.evaluation.statistics import Interval
from mpma_mj.experiments.study import (
    Agents,
    Record,
    Study,
    StudyJob,
    batches,
    of_agent,
    over_seeds,
)
from mpma_mj.motions import Motion
from mpma_mj.motions.reach import check_reach
from mpma_mj.motions.repertoire import join
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import expand_folders, read_motions
from mpma_mj.utils.text import markdown_table, printable

__all__ = ["AGENTS", "REFERENCE", "Unseen"]

AGENTS: Agents = {
    "mpma": {"agent": "mpma"},
    "mpma, 1 × 200": {"agent": "mpma", "modules": 1, "nodes": 200},
    "single, 200": {"agent": "single", "nodes": 200},
    "resolved rate": {"agent": "resolved_rate"},
}
"""Agents of the study."""

REFERENCE = "resolved rate"
"""Agent that learns nothing, with which all others are compared."""

_LEAST = 3  # motions, so that at least two are learned


@dataclass(frozen=True, kw_only=True)
class Unseen(Study):
    """Learn all motions but one together, and imitate that one without learning.

    Attributes:
        motions: Recordings, or folders of them, and built-in motions; ymca is one of them anyway.
        arms: Simulated arms, or arms that move ideally.
        epochs: Epochs in which the others are learned.
        agents: The agents.
    """

    name: ClassVar[str] = "unseen"
    motions: tuple[str, ...] = ()
    arms: Arms = "physics"
    epochs: int = 4
    agents: Agents = field(default_factory=lambda: AGENTS)

    @property
    def sources(self) -> tuple[str, ...]:
        """All motions, each left out once.

        Raises:
            BadOptionError: There are fewer than 3.
        """
        found = tuple(dict.fromkeys(("ymca", *expand_folders(self.motions))))
        if len(found) < _LEAST:
            raise BadOptionError(
                f"{len(found)} motions, {', '.join(found)}; expected at least"
                f" {_LEAST}: each is left out once, and the others are learned",
                remedy="name more recordings",
            )
        return found

    @property
    def titles(self) -> tuple[str, ...]:
        """Names of the motions."""
        return tuple(printable(Path(source).stem) for source in self.sources)

    def jobs(self) -> list[UnseenJob]:
        """Return a job for each left-out motion and batch of runs; errors as of `Study`."""
        sources, titles = self.sources, self.titles
        base = RunConfig.of(*sources, arms=self.arms, repeats=1, seed=self.seed)
        limits = arm_limits(base.env)
        motions = [read_motions(base.replace(motions=(source,))) for source in sources]
        for motion in motions:
            check_reach(motion, *limits)
        jobs = []
        for number, unseen in enumerate(motions):
            others = [motion for motion in motions if motion is not unseen]
            learned = join(others, limits[0])
            names = tuple(n for i, n in enumerate(sources) if i != number)
            jobs += [
                UnseenJob(
                    agent=agent,
                    part=f"{number + 1} {titles[number]}",
                    number=number,
                    configs=configs,
                    learned=learned,
                    unseen=_relabelled(unseen, learned),
                    title=titles[number],
                    epochs=self.epochs,
                )
                for agent, configs in batches(self.agents, base.replace(motions=names), self.runs)
            ]
        return jobs

    def p_e(self, records: Sequence[Record], agent: str, number: int) -> Interval:
        """Return p_e of an agent in a motion that it has not learned, by its index, percent."""
        own = [one for one in of_agent(records, agent) if one["number"] == number]
        return over_seeds(own, "p_e")

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents and motions."""
        rows, titles = [], self.titles
        for agent in self.agents:
            cells = []
            for number in range(len(titles)):
                p_e = self.p_e(records, agent, number)
                apart = p_e.high < self.p_e(records, REFERENCE, number).low
                cells.append(f"**{p_e.text(3)}**" if apart else p_e.text(3))
            rows.append([agent, *cells])
        return (
            f"{markdown_table(['agent', *titles], rows)}\n\n"
            f"p_e in %, of each motion after {self.epochs} epochs of the others, nothing of it"
            f" learned; means over {self.runs} seeds with 95 % bootstrap intervals. Bold: the whole"
            f" interval is below that of {REFERENCE}."
        )

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.points import write_points

        titles = self.titles
        numbers = range(len(titles))
        p_e = {name: [self.p_e(records, name, n) for n in numbers] for name in self.agents}
        labels = ("motion left out", "p_e without learning, %")
        write_points(path, p_e, titles, labels, reference=REFERENCE)


@dataclass(frozen=True, eq=False, kw_only=True)
class UnseenJob(StudyJob):
    """Runs of one agent without one motion; see `StudyJob`.

    Attributes:
        learned: The other motions.
        unseen: The motion, with as many labels as the others together.
        number: Its index.
        title: Its name.
        epochs: Epochs of learning.
    """

    learned: Motion
    unseen: Motion
    number: int
    title: str
    epochs: int

    def do(self) -> list[Record]:
        """Learn the others, and imitate the one left out."""
        _, course, traces = self.learn_and_imitate(self.learned, self.unseen, self.epochs)
        p_e = tracking_errors(traces)
        records: list[Record] = []
        for run, config in enumerate(self.configs):
            own: Record = {"agent": self.agent, "seed": config.seed}
            own |= {"number": self.number, "unseen": self.title}
            diverged = bool(np.isnan([*course[:, run], p_e[run]]).any())
            own |= {"diverged": diverged}
            if len(course) and not diverged:
                own["learned_p_e"] = float(course[-1, run])
            if not diverged:
                own["p_e"] = float(p_e[run])
            records.append(own)
        return records


def _relabelled(motion: Motion, learned: Motion) -> Motion:
    """Return a motion with as many equal segments as another has labels, and their names."""
    context, _ = equal_segments(len(motion), len(learned.labels))
    return dataclasses.replace(motion, context=context, labels=learned.labels)
