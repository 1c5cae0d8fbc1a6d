"""Command `mpma grow`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.folders import write_tables
from mpma_mj.commands.run_options import Motions, RunOptions
from mpma_mj.commands.workers import SweepWorkers, Workers
from mpma_mj.utils.text import printable

__all__ = ["Grow"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Grow(Generic[AgentT]):
    """Grow agents from one module, and compare them with agents of fixed numbers of modules.

    Repeat the command with the same --out to resume.
    """

    motions: Motions = ("ymca",)
    """Motions, as for `mpma imitate`."""
    most: int = 8
    """Largest number of modules."""
    runs: int = 10
    """Growing runs, and runs of each fixed number of modules, with seeds from --seed up."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """Options that determine the result."""
    epochs: int = 100
    """Largest number of epochs of a run; it ends when it has converged."""
    who: SweepWorkers = Workers()
    """Workers that train."""
    out: Path | None = None
    """Folder of the runs; runs/grow-TIME if not given."""

    def run(self) -> Path:
        """Train all runs and return the folder."""
        from mpma_mj.sweep.growth import as_markdown, spec_of

        base = self.options.run_config(self.motions, "grow")
        spec = spec_of(self.most, self.runs, base, self.epochs)
        with self.who.trained(spec, self.out, "grow") as folder:
            from mpma_mj.sweep.growth_figure import write_figure

            runs = folder.finished()
            folder.write_rows(runs)
            title = ", ".join(printable(Path(motion).stem) for motion in base.motions)
            write_figure(folder.path / "growth.png", runs, title)
            write_tables(folder.path, "growth", as_markdown(spec, runs))
            return folder.path
