"""Command `mpma attractor`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mpma_mj.commands.folders import locked_runs, write_result
from mpma_mj.commands.run_options import Outside, OutsideClasses, RunFolders

__all__ = ["Attractor"]


@dataclass(frozen=True)
class Attractor:
    """Free-running: continue trained runs without the demonstration, with the context alone.

    Reports for how long and how precisely they continue, and writes attractor.json and
    figures/attractor.png to the folder of each run.
    """

    run_folders: RunFolders
    """Folders of runs."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Run all agents without demonstration and return the path of the last figure."""
        with locked_runs(self.run_folders, self.outside, "attractor") as folders:
            from mpma_mj.analysis.attractor import dance_freely
            from mpma_mj.analysis.attractor_figure import write_figure
            from mpma_mj.analysis.danced import read_danced
            from mpma_mj.analysis.freedom import as_markdown, judge
            from mpma_mj.utils.progress import show_range

            for folder in folders:
                # Raises for modules without output, which predict no posture.
                read_danced(folder)
            results = {}
            for number in show_range(range(len(folders)), "dancing without demonstration"):
                folder = folders[number]
                free, motion = dance_freely(folder)
                freedom = judge(free)
                results[str(folder.path)] = freedom
                write_result(folder.free_running, motion.name, freedom.as_json())
                picture = folder.figures / "attractor.png"
                write_figure(picture, free, motion)
            print(as_markdown(results))
            return picture
