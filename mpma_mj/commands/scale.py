"""`mpma scale`."""

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

__all__ = ["Scale"]


@dataclass(frozen=True)
class Scale:
    """Train on more and more movements, and on more and more of one: where does it saturate?

    Started again with the same --out it goes on where it was.
    """

    motions: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")] = ()
    """Recordings, or folders of them; the first 1, 2, 4, … are learned together, and of the longest
    the first seconds. Invented dances if none are given."""
    lengths: tuple[float, ...] = ()
    """Seconds of the longest movement; 5, 10, 20 and 40, as far as it goes, if none are given."""
    modules: tuple[int, ...] = (2, 4, 8, 16)
    """Numbers of modules."""
    nodes: tuple[int, ...] = (50, 100, 200, 400)
    """Neurons of each reservoir; modules vary at the middle one, and nodes at the middle one of
    the modules."""
    runs: int = 3
    """Runs of each, with seeds from 0."""
    rule: str = "weighted"
    """Learning rule: weighted is ours, gated the paper's; or the path of a class."""
    arms: Arms = "physics"
    """Simulated arms, or arms that move ideally."""
    proprioception: bool = True
    """Whether models sense the joint angles too; the paper's do not."""
    who: tyro.conf.OmitArgPrefixes[Workers] = dataclasses.field(default_factory=Workers)
    """Who trains."""
    out: Path | None = None
    """Folder; runs/scale-TIME if not given."""

    def run(self) -> Path:
        """Do it and return the folder."""
        from mpma_mj.sweep import scale, scale_table
        from mpma_mj.sweep.folder import SweepFolder
        from mpma_mj.training.dataset import expand_folders
        from mpma_mj.utils.atomic_files import csv_text, write_text

        base = RunConfig.of(rule=self.rule, arms=self.arms, proprioception=self.proprioception)
        learned = scale.materials(expand_folders(self.motions), self.lengths)
        question = scale.Scale(learned, self.modules, self.nodes, base)
        spec = question.spec_of(self.runs)
        with output_folder(self.out, "scale") as path:
            folder = SweepFolder(path, spec)
            self.who.train(folder)
            from mpma_mj.sweep.scale_figure import write_figure

            runs = folder.finished()
            results = scale_table.Results(question, runs)
            markdown = scale_table.as_markdown(results, runs, len(folder.spec.configs))
            folder.write_rows(runs)
            write_text(folder.path / "scale.md", markdown)
            write_text(folder.path / "scale.csv", csv_text(scale_table.as_rows(results)))
            write_figure(folder.path / "scale.png", results)
            print(markdown)
            require_all(folder)
            return folder.path
