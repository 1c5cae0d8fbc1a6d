"""Study `latency`: a motion is learned, and then imitated, with late senses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.late_senses import LateSenses
from mpma_mj.agents.paired_models import PairedModels
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
from mpma_mj.options import Arms
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
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
"""Agents of the study; `lookahead` is that of `SENSES` where they do not say."""

SENSES: Mapping[str, Mapping[str, Any]] = {
    **{f"{k} known": {"latency": k, "lookahead": k + 1} for k in (0, 1, 2, 3, 5)},
    "3 unknown": {"latency": (3, 3), "lookahead": 6},
    "0–5 drawn": {"latency": (0, 5), "lookahead": 6},
    "0–5 jumping": {"latency": (0, 5), "latency_every": (1.5, 4.0), "lookahead": 6},
}
"""Options of the environment, by latency in control steps; as much of the demonstration is shown
as the largest latency needs."""


@dataclass(frozen=True, kw_only=True)
class Latency(Study):
    """Learn a motion with late senses, and imitate it with them.

    Attributes:
        motion: Built-in motion, or path of a recording.
        arms: Simulated arms, or arms that move ideally.
        epochs: Epochs of learning with each latency.
        agents: The agents.
        senses: Options of the environment, by the name of a column.
    """

    name: ClassVar[str] = "latency"
    motion: str = "ymca"
    arms: Arms = "physics"
    epochs: int = 6
    agents: Agents = field(default_factory=lambda: AGENTS)
    senses: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: SENSES)

    def jobs(self) -> list[LatencyJob]:
        """Return a job for each latency and batch of runs; errors as of `Study`."""
        base = RunConfig.of(self.motion, arms=self.arms, seed=self.seed)
        motion = read_motions(base)
        return [
            LatencyJob(agent=agent, part=name, configs=configs, motion=motion, epochs=self.epochs)
            for name, options in self.senses.items()
            for agent, configs in batches(self._agents_with(options), base, self.runs)
        ]

    def p_e(self, records: Sequence[Record], agent: str, senses: str) -> Interval:
        """Return p_e of an agent with a latency, by its name, percent."""
        return over_seeds(self._of(records, agent, senses), "p_e")

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents and latencies."""
        rows = [
            [agent, *(self.p_e(records, agent, name).text(2) for name in self.senses)]
            for agent in self.agents
        ]
        return (
            f"{markdown_table(['agent', *self.senses], rows)}\n\n"
            f"p_e in % with a latency in control steps, after {self.epochs} epochs with it; means"
            f" over {self.runs} seeds with 95 % bootstrap intervals.{self._right(records)}"
        )

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.points import write_points

        p_e = {
            agent: [self.p_e(records, agent, name) for name in self.senses] for agent in self.agents
        }
        titles = [name.replace(" ", "\n", 1) for name in self.senses]
        write_points(path, p_e, titles, ("latency, control steps", "p_e, %"), log=True)

    def _agents_with(self, options: Mapping[str, Any]) -> Agents:
        """Return the agents with options of the environment, those of the agents first."""
        return {name: {**options, **own} for name, own in self.agents.items()}

    def _of(self, records: Sequence[Record], agent: str, senses: str) -> list[Record]:
        return [one for one in of_agent(records, agent) if one["latency"] == senses]

    def _right(self, records: Sequence[Record]) -> str:
        """Return a sentence on delays that the first agent had to find; empty without any."""
        agent = next(iter(self.agents))
        shares = {
            name: over_seeds(self._of(records, agent, name), "right_delay") for name in self.senses
        }
        found = [
            f"{100 * one.mean:.0f} % with {name}" for name, one in shares.items() if one.mean > 0
        ]
        return f" Steps at which {agent} knew the delay: {', '.join(found)}." if found else ""


@dataclass(frozen=True, eq=False, kw_only=True)
class LatencyJob(StudyJob):
    """Runs of one agent with one latency; see `StudyJob`.

    Attributes:
        motion: The motion.
        epochs: Epochs of learning.
    """

    motion: Motion
    epochs: int

    def do(self) -> list[Record]:
        """Learn with the latency, and imitate without learning."""
        agent, course, traces = self.learn_and_imitate(self.motion, self.motion, self.epochs)
        p_e = tracking_errors(traces)
        records: list[Record] = []
        for run, (config, trace) in enumerate(zip(self.configs, traces, strict=True)):
            own: Record = {"agent": self.agent, "seed": config.seed, "latency": self.part}
            own["diverged"] = bool(np.isnan([*course[:, run], p_e[run]]).any())
            if trace is not None and not own["diverged"]:
                own["p_e"] = float(p_e[run])
                own["right_delay"] = _right_delay(agent, run, trace)
            records.append(own)
        return records


def _right_delay(agent: Agent, run: int, trace: Trace) -> float | None:
    """Return the share of steps at which an agent found the delay; None where it looks for none."""
    senses = agent.senses if isinstance(agent, PairedModels) else None
    if not isinstance(senses, LateSenses) or senses.known or trace.latency is None:
        return None
    found: NDArray[np.intp] = np.stack(senses.delays)[:, run]
    return float(np.mean(found == trace.latency))
