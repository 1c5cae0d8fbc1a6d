"""Command `mpma attractor`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mpma_mj.commands.folders import locked_runs
from mpma_mj.commands.run_options import OutsideClasses
from mpma_mj.errors import BadOptionError

__all__ = ["Attractor"]


@dataclass(frozen=True)
class Attractor:
    """Free-running: continue trained runs without the demonstration, with the context alone.

    Reports for how long and how precisely they continue, and writes attractor.json and
    figures/attractor.png to the folder of each run.
    """

    run_folders: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="RUN...")]
    """Folders of runs."""

    outside: Annotated[
        tyro.conf.OmitArgPrefixes[OutsideClasses], tyro.conf.arg(name="outside-class")
    ] = dataclasses.field(default_factory=OutsideClasses)
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Run all agents without demonstration and return the path of the last figure."""
        from mpma_mj.analysis.attractor import dance_freely
        from mpma_mj.analysis.attractor_figure import write_figure
        from mpma_mj.analysis.danced import read_danced
        from mpma_mj.analysis.freedom import as_markdown, judge
        from mpma_mj.training.run_folder import open_runs
        from mpma_mj.utils import atomic_files
        from mpma_mj.utils.progress import show_range

        if not self.run_folders:
            raise BadOptionError("no run given; try: mpma attractor runs/ymca")
        folders = open_runs(self.run_folders, **vars(self.outside))
        with locked_runs(folders):
            for folder in folders:
                # Raises for modules without output, which predict no posture.
                read_danced(folder)
            results = {}
            for number in show_range(range(len(folders)), "dancing without demonstration"):
                folder = folders[number]
                free, motion = dance_freely(folder)
                freedom = judge(free)
                results[str(folder.path)] = freedom
                content = {"format": atomic_files.FORMAT, "motion": motion.name} | freedom.as_json()
                atomic_files.write_json(folder.free_running, content)
                picture = folder.figures / "attractor.png"
                write_figure(picture, free, motion)
            print(as_markdown(results))
            return picture
