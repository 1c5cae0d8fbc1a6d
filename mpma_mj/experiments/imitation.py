"""Studies of agents that learn under several conditions, and then imitate without learning."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mpma_mj.evaluation.statistics import Interval
from mpma_mj.experiments.records import Record, matching, over_seeds
from mpma_mj.experiments.study import Agents, Count, Study, StudyJob
from mpma_mj.options import Arms

if TYPE_CHECKING:
    from mpma_mj.agents import Agent
    from mpma_mj.motions import Motion
    from mpma_mj.trace import Trace

__all__ = ["ImitationJob", "ImitationStudy"]


@dataclass(frozen=True, kw_only=True)
class ImitationStudy(Study):
    """Agents under several conditions; see `Study`.

    Attributes:
        arms: Simulated arms, or arms that move ideally.
        epochs: Epochs of learning.
        agents: The agents.
    """

    arms: Arms = "physics"
    epochs: Count
    agents: Agents

    @abc.abstractmethod
    def conditions(self) -> Sequence[Mapping[str, Any]]:
        """Return entries of the records of each condition that no other has."""

    def p_e(self, records: Sequence[Record]) -> dict[str, list[Interval]]:
        """Return p_e of each agent under each condition, percent."""
        conditions = self.conditions()
        return {
            agent: [
                over_seeds(matching(records, {"agent": agent} | dict(condition)), "p_e")
                for condition in conditions
            ]
            for agent in self.agents
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class ImitationJob(StudyJob):
    """Runs of one agent under one condition; see `StudyJob`.

    Attributes:
        condition: Entries of each record that distinguish the condition.
        learned: What agents learn.
        imitated: What they imitate then.
        epochs: Epochs of learning.
    """

    condition: Mapping[str, Any]
    learned: Motion
    imitated: Motion
    epochs: int

    def do(self) -> list[Record]:
        """Learn, and imitate without learning."""
        import numpy as np

        from mpma_mj.evaluation.evaluate import posture_errors_percent

        agent, course, traces = self.learn_and_imitate(self.learned, self.imitated, self.epochs)
        p_e = posture_errors_percent(traces)
        records: list[Record] = []
        for run, (config, trace) in enumerate(zip(self.configs, traces, strict=True)):
            record: Record = {"agent": self.agent, "seed": config.seed, **self.condition}
            record["diverged"] = bool(np.isnan([*course[:, run], p_e[run]]).any())
            if trace is not None and not record["diverged"]:
                if len(course):
                    record["learned_p_e"] = float(course[-1, run])
                record["p_e"] = float(p_e[run])
                record["right_delay"] = _right_delay(agent, run, trace)
            records.append(record)
        return records


def _right_delay(agent: Agent, run: int, trace: Trace) -> float | None:
    """Return the share of steps at which an agent found the delay; None where it looks for none."""
    import numpy as np

    from mpma_mj.agents.late_senses import LateSenses
    from mpma_mj.agents.paired_models import PairedModels

    senses = agent.senses if isinstance(agent, PairedModels) else None
    if not isinstance(senses, LateSenses) or senses.known or trace.latency is None:
        return None
    return float(np.mean(np.stack(senses.delays)[:, run] == trace.latency))
