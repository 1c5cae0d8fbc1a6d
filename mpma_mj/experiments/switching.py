"""Study `switching`: plants are learned one after the other, then they switch unannounced."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from mpma_mj.envs.options import MASS_OPTIONS
from mpma_mj.experiments.study import (
    Agents,
    Count,
    Record,
    Study,
    batches,
    of_agent,
    over_seeds,
)
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

if TYPE_CHECKING:
    from mpma_mj.experiments.switching_job import SwitchingJob

__all__ = ["AGENTS", "PLANTS", "Switching"]

PLANTS: dict[str, dict[str, float]] = {
    "empty": {},
    "3 kg": {"payload": 3.0},
    "gain 0.6": {"actuator_gain": 0.6},
    "gain 1.5": {"actuator_gain": 1.5},
}
"""Options of the plants by name, in the order in which they are learned (choice)."""

AGENTS: Agents = {
    "mpma": {"agent": "mpma"},
    "mpma, 1 × 200": {"agent": "mpma", "modules": 1, "nodes": 200},
    "single, 200": {"agent": "single", "nodes": 200},
    "single, 800": {"agent": "single", "nodes": 800},
    "single, history": {"agent": "single", "nodes": 200, "history": True},
    "adaptive": {"agent": "adaptive"},
    "resolved rate": {"agent": "resolved_rate"},
    "oracle": {"agent": "oracle"},
}
"""Agents of the study."""

_LESIONED = "mpma"  # whose modules are switched off


@dataclass(frozen=True, kw_only=True)
class Switching(Study):
    """Learn four plants one after the other, then imitate while they switch unannounced.

    Attributes:
        motion: Built-in motion, or path of a recording.
        arms: Simulated arms, or arms that move ideally.
        reverse: Learn the plants in reverse order.
        epochs: Epochs in each plant.
        agents: The agents.
    """

    name: ClassVar[str] = "switching"
    motion: str = "ymca"
    arms: Arms = "physics"
    reverse: bool = False
    epochs: Count = 3
    agents: Agents = field(default_factory=lambda: AGENTS)

    @property
    def plants(self) -> dict[str, dict[str, float]]:
        """The plants in their order; ideal arms have no mass, and carry no load."""
        left_out = set() if self.arms == "physics" else {*MASS_OPTIONS}
        order = reversed(PLANTS) if self.reverse else PLANTS
        return {name: PLANTS[name] for name in order if not {*PLANTS[name]} & left_out}

    def jobs(self) -> list[SwitchingJob]:
        """Return a job for each agent; errors as of `Study`."""
        from mpma_mj.experiments.switching_job import SwitchingJob
        from mpma_mj.training.dataset import read_motions
        from mpma_mj.training.trainer import check

        base = RunConfig.of(
            self.motion,
            arms=self.arms,
            plants=tuple(self.plants.values()),
            epochs_per_plant=self.epochs,
            seed=self.seed,
        )
        motion = read_motions(base)
        check(base, motion)
        return [
            SwitchingJob(
                agent=name,
                configs=configs,
                motion=motion,
                plants=tuple(self.plants),
                drawn_seed=self.seed,
                lesions=name == _LESIONED,
            )
            for name, configs in batches(self.agents, base, self.runs)
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents, and the lesions of mpma."""
        head = ["agent", *self.plants, "mean", "switched", "first plant kept", "plants found"]
        head += ["steps to lead", "right plant leads", "learned share", "feedback ratio"]
        rows = [self._row(agent, of_agent(records, agent)) for agent in self.agents]
        parts = [
            markdown_table(head, rows),
            f"p_e in %; means over {self.runs} seeds with 95 % bootstrap intervals. First plant"
            f" kept: p_e in {next(iter(self.plants))} after all plants over p_e there before the"
            f" second. Plants found: runs that found exactly {len(self.plants)}. Steps to lead:"
            " median from a switch to the first step in which the modules of the right plant"
            " lead; the whole stretch where they never do. Right plant leads: share of steps while"
            f" plants switch; where two share modules, these count in both.",
        ]
        lesioned = [one for one in of_agent(records, _LESIONED) if "lesion" in one]
        if lesioned:
            cells = [
                [off, *(over_seeds(lesioned, "lesion", off, on).text(2) for on in self.plants)]
                for off in self.plants
            ]
            parts += [
                markdown_table(
                    ["modules switched off", *(f"in {on}" for on in self.plants)], cells
                ),
                f"p_e of {_LESIONED} over that of the intact agent, by the plant whose modules are"
                " switched off and the plant that is on.",
            ]
        return "\n\n".join(parts)

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.switching_figure import write_figure

        write_figure(path, records, tuple(self.agents), tuple(self.plants))

    def _row(self, agent: str, records: Sequence[Record]) -> list[str]:
        cells = [over_seeds(records, "p_e", plant).text(2) for plant in self.plants]
        cells += [over_seeds(records, name).text(3) for name in ("mean", "switched")]
        cells.append(over_seeds(records, "first_kept").text(2))
        found = [one["plants"] for one in records if one.get("plants") is not None]
        cells.append(f"{found.count(len(self.plants))} of {len(found)}" if found else "–")
        steps = [s for one in records for s in one.get("steps_to_lead") or ()]
        cells.append(f"{statistics.median(steps):g}" if steps else "–")
        shares = ("right_share", "learned_share", "feedback_ratio")
        return [agent, *cells, *(over_seeds(records, name).text(3) for name in shares)]
