"""Command `mpma ablate`."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mpma_mj.commands.folders import output_folder
from mpma_mj.commands.workers import Workers, require_all
from mpma_mj.training.config import RunConfig

__all__ = ["Ablate"]


@dataclass(frozen=True)
class Ablate:
    """Ablation study: train MPMA on the YMCA with one component changed at a time.

    Repeat the command with the same --out to resume.
    """

    rule: str = "weighted"
    """Learning rule: weighted (ours), gated (the paper's), or the path of a class."""
    runs: int = 20
    """Runs of each variant, with seeds from 0."""
    nodes: int = 100
    """Neurons of each reservoir."""
    who: Annotated[tyro.conf.OmitArgPrefixes[Workers], tyro.conf.arg(name="worker")] = (
        dataclasses.field(default_factory=Workers)
    )
    """Workers that train."""
    out: Path | None = None
    """Folder of the tables; runs/ablate-TIME if not given."""

    def run(self) -> Path:
        """Run the ablation study and return its folder."""
        from mpma_mj.sweep import ablation
        from mpma_mj.sweep.folder import SweepFolder
        from mpma_mj.utils.atomic_files import write_text

        spec = ablation.spec_of(RunConfig.of(rule=self.rule, nodes=self.nodes), self.runs)
        with output_folder(self.out, "ablate") as path:
            folder = SweepFolder(path, spec)
            self.who.train(folder, functools.partial(ablation.title, spec))
            runs = folder.finished()
            markdown = ablation.as_markdown(spec, runs)
            folder.write_rows(runs)
            write_text(folder.path / "ablate.md", markdown)
            write_text(folder.path / "ablate.csv", ablation.as_csv(spec, runs))
            print(markdown)
            require_all(folder)
            return folder.path
