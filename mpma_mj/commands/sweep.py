"""Command `mpma sweep`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.run_options import Motions, RunOptions
from mpma_mj.commands.workers import StudyWorkers, Workers
from mpma_mj.errors import BadOptionError, placeholder

__all__ = ["Sweep"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Sweep(Generic[AgentT]):
    """Train runs at all points of a grid of options, and print a table of the results.

    Repeat the command with the same --out to resume.
    """

    motions: Motions = ("ymca",)
    grid: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=VALUE,VALUE,…")] = ()
    """Options that vary, such as nodes=50,200 modules=2,4."""
    runs: int = 20
    """Runs of each point, with seeds from --seed up."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """Options that determine the result."""
    epochs: int = 30
    """Largest number of epochs of a run; it ends when it has converged."""
    who: StudyWorkers = Workers()
    """Workers that train."""
    out: Path | None = None
    """Folder of the sweep; runs/sweep-TIME if not given."""

    def run(self) -> Path:
        """Train all runs, print their table and return the folder."""
        from mpma_mj.experiments import sweep

        for word in self.motions:
            if "=" in word and not Path(word).exists():
                remedy = f"did you mean {placeholder('grid', word)}?"
                raise BadOptionError(f"no motion '{word}'", remedy=remedy)
        base = self.options.run_config(self.motions, "sweep")
        study = sweep.Sweep(
            grid=self.grid, base=base, runs=self.runs, seed=base.seed, epochs=self.epochs
        )
        return self.who.run(study, self.out, "sweep")
