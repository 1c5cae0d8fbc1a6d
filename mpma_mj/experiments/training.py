"""Studies whose runs are trained until they converge, each at several points."""

from __future__ import annotations

import abc
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from mpma_mj.errors import BadOptionError
from mpma_mj.evaluation.statistics import Interval, MeanStd
from mpma_mj.experiments.batching import seeds
from mpma_mj.experiments.records import Record, converged, mean_std_over_seeds
from mpma_mj.experiments.study import Count, Study, StudyJob
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import printable

if TYPE_CHECKING:
    from mpma_mj.motions import Motion

__all__ = ["COLUMNS", "Column", "Point", "TrainingJob", "TrainingStudy", "short"]


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        title: Its title.
        measure: Name of the measure in a record, with the name of a nested entry after a point.
        digits: Number of digits after the decimal point.
    """

    title: str
    measure: str
    digits: int

    @property
    def path(self) -> list[str]:
        """Path of the measure in a record."""
        return self.measure.split(".")


COLUMNS = {
    column.measure: column
    for column in (
        Column("p_e, %", "p_e_percent", 2),
        Column("feedback ratio", "feedback_ratio", 3),
        Column("learned share", "learned_share", 3),
        Column("epochs", "epochs", 1),
        Column("environment steps", "environment_steps", 0),
        Column("nmi", "nmi", 2),
        Column("modules used", "modules_used", 1),
        Column("active modules", "active_modules", 2),
        Column("repeatability of λ", "repeatability.responsibility", 3),
    )
}
"""Columns of several studies, by their measures."""


class Point(NamedTuple):
    """A row of a study.

    Attributes:
        labels: Entries of its records that distinguish it from other points.
        config: Its config, with the first seed.
    """

    labels: Mapping[str, Any]
    config: RunConfig


@dataclass(frozen=True, kw_only=True)
class TrainingStudy(Study):
    """Runs that are trained until they converge; see `Study`.

    Attributes:
        epochs: Largest number of epochs of a run; it ends when it has converged.
    """

    runs: Count = 20
    epochs: Count = 30
    stop = True  # a field where it is an option

    @abc.abstractmethod
    def points(self) -> Sequence[Point]:
        """Return all points, of different labels."""

    def jobs(self) -> list[TrainingJob]:
        """Return a job for each point; errors as of `Study`."""
        from mpma_mj.training.dataset import read_motions
        from mpma_mj.training.trainer import check

        points = self.points()
        if not points:
            raise BadOptionError("no runs are requested; expected at least 1")
        if len({point.config for point in points}) < len(points):
            raise BadOptionError("the same run is requested twice; leave one out")
        motions: dict[tuple[object, ...], Motion] = {}  # by all that reading depends on
        jobs = []
        for labels, config in points:
            env = config.env
            source = (config.motions, config.reading, env.arms, env.robot, env.control_timestep)
            if source not in motions:
                motions[source] = read_motions(config)
            configs = tuple(seeds(config, self.runs))
            check(config, motions[source])
            jobs.append(
                TrainingJob(
                    agent=config.agent_name,
                    part=", ".join(f"{k} {short(v)}" for k, v in labels.items() if k != "agent"),
                    configs=configs,
                    labels=labels,
                    motion=motions[source],
                    epochs=self.epochs,
                    stop=self.stop,
                )
            )
        return jobs

    def cells(
        self,
        records: Sequence[Record],
        columns: Sequence[Column],
        over_seeds: Callable[..., Interval | MeanStd] = mean_std_over_seeds,
    ) -> list[str]:
        """Return how many runs of a point converged, and the cells of columns.

        Args:
            records: Records of the point.
            columns: The columns.
            over_seeds: Statistic of a measure, given records and its path.
        """
        found = (over_seeds(records, *column.path).text(column.digits) for column in columns)
        return [f"{converged(records)} of {self.runs}", *found]


def short(value: object) -> str:
    """Return a label as text, a path without its folders."""
    return printable(Path(value).name) if isinstance(value, str) else str(value)


@dataclass(frozen=True, eq=False, kw_only=True)
class TrainingJob(StudyJob):
    """Runs of one point; see `StudyJob`.

    Attributes:
        labels: Entries of each record that distinguish the point.
        motion: The motion, which is sent along, so that workers need no recording.
        epochs: Largest number of epochs of a run.
        stop: Whether a run ends when it has converged.
    """

    labels: Mapping[str, Any]
    motion: Motion
    epochs: int
    stop: bool

    def do(self) -> list[Record]:
        """Train the runs, and return their summaries with their shares of the time.

        Raises:
            MpmaError: The config does not fit the motion.
        """
        from mpma_mj.training.trainer import train_batch

        began = time.perf_counter()
        summaries = train_batch(self.configs, self.motion, self.epochs, stop=self.stop)
        seconds = (time.perf_counter() - began) / len(summaries)
        return [
            {"agent": self.agent, **self.labels, "seed": config.seed}
            | {"diverged": "failed" in summary, "seconds": seconds}
            | summary
            for config, summary in zip(self.configs, summaries, strict=True)
        ]
