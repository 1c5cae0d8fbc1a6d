"""Study `latency`: a motion is learned, and then imitated, with late senses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from mpma_mj.experiments.imitation import ImitationJob, ImitationStudy
from mpma_mj.experiments.records import Record, matching, over_seeds
from mpma_mj.experiments.study import Agents, Count, batches
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

__all__ = ["AGENTS", "SENSES", "Latency"]

AGENTS: Agents = {
    "mpma": {"agent": "mpma"},
    "mpma, one step shown": {"agent": "mpma", "lookahead": 0},
    "mpma, no compensation": {"agent": "mpma", "max_latency": 0},
    "single, 200": {"agent": "single", "nodes": 200},
    "adaptive": {"agent": "adaptive"},
    "resolved rate": {"agent": "resolved_rate"},
}
"""Agents of the study; `lookahead` is that of `SENSES` where an agent has none of its own."""

SENSES: Mapping[str, Mapping[str, Any]] = {
    **{f"{k} known": {"latency": k, "lookahead": k + 1} for k in (0, 1, 2, 3, 5)},
    "3 unknown": {"latency": (3, 3), "lookahead": 6},
    "0–5 drawn": {"latency": (0, 5), "lookahead": 6},
    "0–5 jumping": {"latency": (0, 5), "latency_every": (1.5, 4.0), "lookahead": 6},
}
"""Options of the environment, by latency in control steps; as much of the demonstration is shown
as the largest latency needs."""


@dataclass(frozen=True, kw_only=True)
class Latency(ImitationStudy):
    """Learn a motion with late senses, and imitate it with them.

    Attributes:
        motion: Built-in motion, or path of a recording.
        senses: Options of the environment, by the name of a column.
    """

    name: ClassVar[str] = "latency"
    motion: str = "ymca"
    epochs: Count = 6
    agents: Agents = field(default_factory=lambda: AGENTS)
    senses: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: SENSES)

    def conditions(self) -> list[dict[str, str]]:
        """Return the latencies."""
        return [{"latency": name} for name in self.senses]

    def jobs(self) -> list[ImitationJob]:
        """Return a job for each latency and agent; errors as of `Study`."""
        from mpma_mj.training.dataset import read_motions

        base = RunConfig.of(self.motion, arms=self.arms, seed=self.seed)
        motion = read_motions(base)
        return [
            ImitationJob(
                agent=agent,
                part=name,
                configs=configs,
                condition={"latency": name},
                learned=motion,
                imitated=motion,
                epochs=self.epochs,
            )
            for name, options in self.senses.items()
            for agent, configs in batches(self._agents_with(options), base, self.runs)
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents and latencies."""
        rows = [
            [agent, *(one.text(2) for one in found)] for agent, found in self.p_e(records).items()
        ]
        return (
            f"{markdown_table(['agent', *self.senses], rows)}\n\n"
            f"p_e in % with a latency in control steps, after {self.epochs} epochs with it; means"
            f" over {self.runs} seeds with 95 % bootstrap intervals.{self._right(records)}"
        )

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.points import write_points

        titles = [name.replace(" ", "\n", 1) for name in self.senses]
        labels = ("latency, control steps", "p_e, %")
        write_points(path, self.p_e(records), titles, labels, log=True)

    def _agents_with(self, options: Mapping[str, Any]) -> Agents:
        """Return the agents with options of the environment, those of the agents first."""
        return {name: {**options, **own} for name, own in self.agents.items()}

    def _right(self, records: Sequence[Record]) -> str:
        """Return a sentence on delays that the first agent had to find; empty without any."""
        agent = next(iter(self.agents))
        shares = {
            name: over_seeds(matching(records, {"agent": agent, "latency": name}), "right_delay")
            for name in self.senses
        }
        found = [
            f"{100 * one.mean:.0f} % with {name}" for name, one in shares.items() if one.mean > 0
        ]
        return f" Steps at which {agent} found the delay: {', '.join(found)}." if found else ""
