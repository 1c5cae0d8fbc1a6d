"""Study `robustness`: agents are trained, and then evaluated under disturbances."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar

from mpma_mj.agents import agent_class
from mpma_mj.errors import DivergedError
from mpma_mj.evaluation import robustness
from mpma_mj.evaluation.disturbances import DisturbanceLevel, disturbance_levels
from mpma_mj.experiments.study import Agents, Count, Record, Study, StudyJob, batches
from mpma_mj.motions import Motion
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.trainer import check, train_agents
from mpma_mj.utils.validation import Bounds

__all__ = ["AGENTS", "Robustness"]

AGENTS: Agents = {
    "mpma": {"agent": "mpma"},
    "single": {"agent": "single"},
    "mosaic": {"agent": "mosaic"},
    "hammer": {"agent": "hammer"},
    "resolved rate": {"agent": "resolved_rate"},
    "feedback only": {"agent": "feedback_only"},
}
"""Agents of the study."""


@dataclass(frozen=True, kw_only=True)
class Robustness(Study):
    """Train agents, and evaluate them under disturbances.

    Attributes:
        motion: Built-in motion, or path of a recording.
        arms: Simulated arms, or arms that move ideally.
        epochs: Largest number of epochs of a training, which ends when it has converged.
        fine_tune: Epochs of fine-tuning in each condition; 0 for none.
        disturbances: Some of payload, strength, gravity, latency, noise, pushes, tempo, mirrored,
            locked, unseen; all that the arms can have if not given.
        agents: The agents.
    """

    name: ClassVar[str] = "robustness"
    motion: str = "ymca"
    arms: Arms = "physics"
    epochs: Count = 30
    fine_tune: Annotated[int, Bounds(0, 1_000_000)] = 0
    disturbances: tuple[str, ...] = ()
    agents: Agents = field(default_factory=lambda: AGENTS)

    def jobs(self) -> list[RobustnessJob]:
        """Return a job for each agent; errors as of `Study`.

        Runs that are fine-tuned have one for each disturbance: training them again costs less.
        """
        base = RunConfig.of(self.motion, arms=self.arms, seed=self.seed)
        motion = read_motions(base)
        check(base, motion)
        levels = disturbance_levels(base, motion, disturbances=self.disturbances, arms=self.arms)
        each = itertools.groupby(levels, key=lambda one: one.disturbance)
        parts = {name: tuple(group) for name, group in each}
        jobs = []
        for agent, configs in batches(self.agents, base, self.runs):
            tunes = self.fine_tune > 0 and agent_class(configs[0].agent_name).fine_tunable
            jobs += [
                RobustnessJob(
                    agent=agent,
                    part=part,
                    configs=configs,
                    motion=motion,
                    epochs=self.epochs,
                    levels=some,
                    fine_tune=self.fine_tune if tunes else 0,
                )
                for part, some in (parts if tunes else {"": levels}).items()
            ]
        return jobs

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents and levels."""
        return robustness.as_markdown(self._results(records))

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure, and that of fine-tuning."""
        from mpma_mj.evaluation.robustness_figure import write_figures

        if records:
            write_figures(path, self._results(records))

    def _results(self, records: Sequence[Record]) -> robustness.Robustness:
        names = [entry.name for entry in dataclasses.fields(robustness.LevelResult)]
        results = [robustness.LevelResult(**{n: one[n] for n in names}) for one in records]
        return robustness.Robustness(results, tuple(self.agents), self.fine_tune)


@dataclass(frozen=True, eq=False, kw_only=True)
class RobustnessJob(StudyJob):
    """Runs of one agent, evaluated at some levels; see `StudyJob`.

    Attributes:
        motion: The motion.
        epochs: Largest number of epochs of training.
        levels: Levels of disturbances.
        fine_tune: Epochs of fine-tuning at each; 0 for none.
    """

    motion: Motion
    epochs: int
    levels: tuple[DisturbanceLevel, ...]
    fine_tune: int

    def do(self) -> list[Record]:
        """Train the agents, and evaluate them at each level.

        Raises:
            DivergedError: A simulation diverged in training; the error names agent and seed.
        """
        try:
            trained = train_agents(self.configs, self.motion, self.epochs, {})
        except DivergedError as error:
            raise error.with_context(self.agent) from None
        results = robustness.evaluate_levels(self.agent, trained, self.levels, self.fine_tune)
        # Episodes may diverge, which their outcome says, but no run that is a row of records.
        return [{**dataclasses.asdict(one), "diverged": False} for one in results]
