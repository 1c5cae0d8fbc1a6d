"""Command `mpma table1`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mpma_mj.commands.folders import write_tables
from mpma_mj.commands.workers import SweepWorkers, Workers
from mpma_mj.options import Arms, Models
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.system import processors

__all__ = ["Table1"]


@dataclass(frozen=True)
class Table1:
    """Reproduce Table 1 of the paper: train the YMCA with networks of several sizes.

    Repeat the command with the same --out to resume.
    """

    nodes: tuple[int, ...] = (50, 100, 200, 400)
    """Sizes: neurons of each reservoir."""
    runs: int = 20
    """Runs of each size, with seeds from 0."""
    models: Models = "joint"
    """Joint models (ours), or posture models (the paper's)."""
    rule: str = "weighted"
    """Learning rule: weighted (ours), gated (the paper's), or the path of a class."""
    arms: Arms = "physics"
    """Simulated arms, or arms that move ideally."""
    who: SweepWorkers = Workers()
    """Workers that train."""
    out: Path | None = None
    """Folder of the table; runs/table1-TIME if not given."""

    def _base(self) -> RunConfig:
        return RunConfig.of(models=self.models, rule=self.rule, arms=self.arms)

    def run(self) -> Path:
        """Train all runs and return the folder."""
        from mpma_mj.experiments import table1

        spec = table1.spec_of(self.nodes, self.runs, self._base())
        with self.who.trained(spec, self.out, "table1") as folder:
            from mpma_mj.experiments import floor
            from mpma_mj.experiments.table1_figure import write_figure
            from mpma_mj.utils.progress import show_range

            runs = folder.finished()
            markdown = table1.as_markdown(spec, runs)
            if self.arms == "physics" and not all(run.diverged for run in runs):
                rounds = show_range(range(floor.ROUNDS), "timing bare physics")
                threads = self.who.workers or processors()
                comparison = floor.beside_bare_physics(folder.seconds(), runs, threads, rounds)
                markdown += f"\n{comparison}\n"
            folder.write_rows(runs)
            write_figure(folder.path / "table1.png", spec, runs)
            write_tables(folder.path, "table1", markdown, table1.as_csv(spec, runs))
            return folder.path
