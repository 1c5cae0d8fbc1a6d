"""Study `agents`: all agents in the same environments, in one table."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, get_args

from mpma_mj.agents.registry import agent_class
from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.statistics import mean_std
from mpma_mj.experiments.records import Record, matching, measured, over_seeds
from mpma_mj.experiments.study import Count
from mpma_mj.experiments.training import COLUMNS, Point, TrainingStudy, short
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

__all__ = ["CompareAgents"]

_BUILT_IN = "ymca"

_MEASURES = ("p_e_percent", "feedback_ratio", "learned_share", "epochs", "environment_steps")
_COLUMNS = [COLUMNS[name] for name in (*_MEASURES, "nmi", "modules_used")]


@dataclass(frozen=True, kw_only=True)
class CompareAgents(TrainingStudy):
    """Train all agents on the YMCA and on recordings, with both kinds of arms.

    Attributes:
        motions: Recordings, or folders of them; each is learned separately.
        agents: Agents, or paths of classes such as my_agents.py:MyAgent.
        nodes: Neurons of each reservoir; each agent's own default if not given.
        stop: End a run when it has converged; otherwise train all epochs, of which the best counts.
        reading: Options of reading recordings.
    """

    name: ClassVar[str] = "agents"
    motions: tuple[str, ...] = ()
    agents: tuple[str, ...] = (
        *("mpma", "single", "adaptive", "resolved_rate", "mosaic", "hammer"),
        *("feedback_only", "open_loop", "random"),
    )
    runs: Count = 5
    nodes: int | None = None
    stop: bool = True
    reading: ReadingOptions = ReadingOptions()

    def points(self) -> list[Point]:
        """Return a point for each motion, kind of arms and agent."""
        return [
            Point(
                {"motion": base.motions[0], "arms": arms, "agent": agent},
                base.replace(arms=arms, agent=agent),
            )
            for base in self._bases()
            for arms in get_args(Arms)
            for agent in self.agents
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return a row for each point."""
        titles = ["motion", "arms", "agent", "converged", *(column.title for column in _COLUMNS)]
        rows = []
        for labels, config in self.points():
            own = matching(records, labels)
            seconds = mean_std(measured(own, "seconds")).mean
            cells = self.cells(own, _COLUMNS, over_seeds)
            if not agent_class(config.agent_name).trainable:
                cells[0] = "–"
            names = short(labels["motion"]), labels["arms"], labels["agent"]
            rows.append([*names, *cells, f"{seconds:.2g}" if own else "–"])
        return (
            f"{markdown_table([*titles, 'seconds a run'], rows)}\n\n"
            "Means over seeds, in brackets their 95 % bootstrap intervals, unless all seeds have"
            " the same. A run's seconds are its share of the time in which one process trained"
            " several runs of the row together."
        )

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.agents_figure import write_figure

        p_e = {
            tuple(labels.values()): measured(matching(records, labels), "p_e_percent")
            for labels, _ in self.points()
        }
        write_figure(path, p_e)

    def _bases(self) -> list[RunConfig]:
        """Return the config of each motion; options of reading apply to recordings only."""
        from mpma_mj.training.dataset import expand_folders

        motions = expand_folders(self.motions)
        for motion in motions:
            if motions.count(motion) > 1:
                raise BadOptionError(
                    f"{motion} is given twice; each is learned separately, give it once"
                )
        sizes = {} if self.nodes is None else {"nodes": self.nodes}
        built_in = RunConfig.of(tempo=self.reading.tempo, seed=self.seed, **sizes)
        of_recordings = dataclasses.replace(built_in, reading=self.reading)
        recordings = (motion for motion in motions if motion != _BUILT_IN)
        return [built_in, *(of_recordings.replace(motions=(motion,)) for motion in recordings)]
