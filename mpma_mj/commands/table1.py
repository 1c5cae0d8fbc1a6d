"""Command `mpma table1`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mpma_mj.commands.folders import output_folder
from mpma_mj.commands.workers import Workers, require_all
from mpma_mj.options import Arms
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
    rule: str = "weighted"
    """Learning rule: weighted (ours), gated (the paper's), or the path of a class."""
    arms: Arms = "physics"
    """Simulated arms, or arms that move ideally."""
    who: Annotated[tyro.conf.OmitArgPrefixes[Workers], tyro.conf.arg(name="worker")] = (
        dataclasses.field(default_factory=Workers)
    )
    """Workers that train."""
    out: Path | None = None
    """Folder of the table; runs/table1-TIME if not given."""

    def run(self) -> Path:
        """Train all runs and return the folder."""
        from mpma_mj.sweep import table1
        from mpma_mj.sweep.folder import SweepFolder
        from mpma_mj.utils.atomic_files import write_text

        spec = table1.spec_of(self.nodes, self.runs, RunConfig.of(rule=self.rule, arms=self.arms))
        with output_folder(self.out, "table1") as path:
            folder = SweepFolder(path, spec)
            self.who.train(folder)
            from mpma_mj.sweep import floor
            from mpma_mj.sweep.table1_figure import write_figure
            from mpma_mj.utils.progress import show_range

            runs = folder.finished()
            markdown = table1.as_markdown(spec, runs)
            if self.arms == "physics" and not all(run.diverged for run in runs):
                rounds = show_range(range(floor.ROUNDS), "timing bare physics")
                threads = self.who.workers or processors()
                comparison = floor.beside_bare_physics(folder.seconds(), runs, threads, rounds)
                markdown += f"\n{comparison}\n"
            folder.write_rows(runs)
            write_text(folder.path / "table1.md", markdown)
            write_text(folder.path / "table1.csv", table1.as_csv(spec, runs))
            write_figure(folder.path / "table1.png", spec, runs)
            print(markdown)
            require_all(folder)
            return folder.path
