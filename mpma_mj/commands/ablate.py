"""Command `mpma ablate`."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

from mpma_mj.commands.folders import write_tables
from mpma_mj.commands.workers import SweepWorkers, Workers
from mpma_mj.options import Models
from mpma_mj.training.config import RunConfig

__all__ = ["Ablate"]


@dataclass(frozen=True)
class Ablate:
    """Ablation study: train MPMA on the YMCA with one component changed at a time.

    Repeat the command with the same --out to resume.
    """

    models: Models = "joint"
    """Joint models (ours), or posture models (the paper's)."""
    rule: str = "weighted"
    """Learning rule: weighted (ours), gated (the paper's), or the path of a class."""
    runs: int = 20
    """Runs of each variant, with seeds from 0."""
    nodes: int = 100
    """Neurons of each reservoir."""
    who: SweepWorkers = Workers()
    """Workers that train."""
    out: Path | None = None
    """Folder of the tables; runs/ablate-TIME if not given."""

    def run(self) -> Path:
        """Run the ablation study and return its folder."""
        from mpma_mj.experiments import ablation

        whole = RunConfig.of(models=self.models, rule=self.rule, nodes=self.nodes)
        spec = ablation.spec_of(whole, self.runs)
        title = functools.partial(ablation.title, spec)
        with self.who.trained(spec, self.out, "ablate", title) as folder:
            runs = folder.finished()
            folder.write_rows(runs)
            tables = ablation.as_markdown(spec, runs), ablation.as_csv(spec, runs)
            write_tables(folder.path, "ablate", *tables)
            return folder.path
