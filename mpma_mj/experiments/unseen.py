"""Study `unseen`: all motions but one are learned together, then that one is imitated."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.imitation import ImitationJob, ImitationStudy
from mpma_mj.experiments.records import Record
from mpma_mj.experiments.study import Agents, Count, batches
from mpma_mj.motions.built_in import file_stem
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table, printable

if TYPE_CHECKING:
    from mpma_mj.motions import Motion

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
class Unseen(ImitationStudy):
    """Learn all motions but one together, and imitate that one without learning.

    Attributes:
        motions: Recordings, or folders of them, and built-in motions; ymca is one of them anyway.
    """

    name: ClassVar[str] = "unseen"
    motions: tuple[str, ...] = ()
    epochs: Count = 4
    agents: Agents = field(default_factory=lambda: AGENTS)

    @property
    def sources(self) -> tuple[str, ...]:
        """All motions, each left out once.

        Raises:
            BadOptionError: There are fewer than 3.
        """
        from mpma_mj.training.dataset import expand_folders

        found = tuple(dict.fromkeys(("ymca", *expand_folders(self.motions))))
        if len(found) < _LEAST:
            raise BadOptionError(
                f"expected at least {_LEAST} motions, not only {' and '.join(found)}, as each is"
                " left out once while the others are learned",
                remedy="name more recordings",
            )
        return found

    def conditions(self) -> list[dict[str, Any]]:
        """Return number and name of each motion that is left out."""
        names = (printable(file_stem(source)) for source in self.sources)
        return [{"number": number, "unseen": name} for number, name in enumerate(names)]

    def jobs(self) -> list[ImitationJob]:
        """Return a job for each left-out motion and agent; errors as of `Study`."""
        from mpma_mj.envs.load import arm_limits
        from mpma_mj.motions.transforms import join
        from mpma_mj.training.dataset import read_motions

        sources = self.sources
        base = RunConfig.of(*sources, arms=self.arms, repeats=1, seed=self.seed)
        limits = arm_limits(base.env)
        motions = [read_motions(base.replace(motions=(source,))) for source in sources]
        jobs = []
        for source, unseen, condition in zip(sources, motions, self.conditions(), strict=True):
            learned = join([motion for motion in motions if motion is not unseen], limits.max_speed)
            others = base.replace(motions=tuple(one for one in sources if one != source))
            jobs += [
                ImitationJob(
                    agent=agent,
                    part=f"{condition['number'] + 1} {condition['unseen']}",
                    configs=configs,
                    condition=condition,
                    learned=learned,
                    imitated=_relabelled(unseen, learned),
                    epochs=self.epochs,
                )
                for agent, configs in batches(self.agents, others, self.runs)
            ]
        return jobs

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents and motions."""
        p_e = self.p_e(records)
        rows = [
            [agent]
            + [
                f"**{one.text(3)}**" if one.high < reference.low else one.text(3)
                for one, reference in zip(found, p_e[REFERENCE], strict=True)
            ]
            for agent, found in p_e.items()
        ]
        return (
            f"{markdown_table(['agent', *self._titles], rows)}\n\n"
            f"p_e in %, of each motion after {self.epochs} epochs of the others, nothing of it"
            f" learned; means over {self.runs} seeds with 95 % bootstrap intervals. Bold: the whole"
            f" interval is below that of {REFERENCE}."
        )

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.points import write_points

        labels = ("motion left out", "p_e without learning, %")
        write_points(path, self.p_e(records), self._titles, labels, reference=REFERENCE)

    @property
    def _titles(self) -> list[str]:
        return [condition["unseen"] for condition in self.conditions()]


def _relabelled(motion: Motion, learned: Motion) -> Motion:
    """Return a motion with as many equal segments as another has labels, and their names."""
    from mpma_mj.context import equal_segments

    context, _ = equal_segments(len(motion), len(learned.labels))
    return dataclasses.replace(motion, context=context, labels=learned.labels)
