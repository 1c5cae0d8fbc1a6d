"""Command `mpma scale`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mpma_mj.commands.folders import write_tables
from mpma_mj.commands.run_options import Motions
from mpma_mj.commands.workers import SweepWorkers, Workers
from mpma_mj.options import Arms, Models
from mpma_mj.training.config import RunConfig

__all__ = ["Scale"]


@dataclass(frozen=True)
class Scale:
    """Scaling study: train on increasing numbers of motions, and on motions of increasing length.

    Reports at which size the agents saturate. Repeat the command with the same --out to resume.
    """

    motions: Motions = ()
    """Recordings, or folders of them; the first 1, 2, 4, … are learned together, and the first
    seconds of the longest one. Synthetic motions if none are given."""
    lengths: tuple[float, ...] = ()
    """Lengths of the longest motion, s; 5, 10, 20 and 40, up to its length, if none are given."""
    modules: tuple[int, ...] = (2, 4, 8, 16)
    """Numbers of modules."""
    nodes: tuple[int, ...] = (50, 100, 200, 400)
    """Neurons of each reservoir; modules vary at the middle value, and nodes at the middle number
    of modules."""
    runs: int = 3
    """Runs of each size, with seeds from 0."""
    models: Models = "joint"
    """Joint models (ours), or posture models (the paper's)."""
    rule: str = "weighted"
    """Learning rule: weighted (ours), gated (the paper's), or the path of a class."""
    arms: Arms = "physics"
    """Simulated arms, or arms that move ideally."""
    proprioception: bool = True
    """Whether posture models receive the joint angles too; the paper's do not."""
    who: SweepWorkers = Workers()
    """Workers that train."""
    out: Path | None = None
    """Folder of the tables; runs/scale-TIME if not given."""

    def run(self) -> Path:
        """Run the scaling study and return its folder."""
        from mpma_mj.experiments import scaling as scale
        from mpma_mj.experiments import scaling_table as scale_table
        from mpma_mj.training.dataset import expand_folders
        from mpma_mj.utils.atomic_files import csv_text

        base = RunConfig.of(
            models=self.models,
            rule=self.rule,
            arms=self.arms,
            proprioception=self.proprioception,
        )
        materials = scale.materials(expand_folders(self.motions), self.lengths)
        study = scale.Scale(materials, self.modules, self.nodes, base)
        spec = study.spec_of(self.runs)
        with self.who.trained(spec, self.out, "scale") as folder:
            from mpma_mj.experiments.scaling_figure import write_figure

            runs = folder.finished()
            results = scale_table.Results(study, runs)
            markdown = scale_table.as_markdown(results, runs, len(folder.spec.configs))
            folder.write_rows(runs)
            write_figure(folder.path / "scale.png", results)
            csv = csv_text(scale_table.as_rows(results))
            write_tables(folder.path, "scale", markdown, csv)
            return folder.path
