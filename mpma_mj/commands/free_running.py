"""Command `mpma free-running`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mpma_mj.commands.folders import locked_runs, write_result
from mpma_mj.commands.run_options import Outside, OutsideClasses, RunFolders

__all__ = ["FreeRunningCommand"]


@dataclass(frozen=True)
class FreeRunningCommand:
    """Free-running: continue trained runs without the demonstration, with the context alone.

    In its place they receive their own prediction, or what a reservoir anticipates that has learned
    the demonstration. Reports for how long and how precisely they continue, and writes
    free_running.json and figures/free_running.png to the folder of each run.
    """

    run_folders: RunFolders
    """Folders of runs."""

    beat: float | None = None
    """Length of the parts into which the context of that reservoir divides the motion, s; its
    labels are the context if not given."""

    outside: Outside = OutsideClasses()
    """Code from outside the package with which runs were trained."""

    def run(self) -> Path:
        """Run all agents without demonstration and return the path of the last figure."""
        from mpma_mj.analysis.epoch_trace import read_danced
        from mpma_mj.analysis.free_running import ANTICIPATION, run_freely
        from mpma_mj.analysis.free_running_figure import write_figure
        from mpma_mj.analysis.free_running_measures import FreeRunMeasures, as_markdown, measure
        from mpma_mj.utils.progress import show_range

        with locked_runs(self.run_folders, self.outside, "free-running") as folders:
            for folder in folders:
                # Raises for modules without output, which predict no posture.
                read_danced(folder)
            results: dict[str, FreeRunMeasures] = {}
            for number in show_range(range(len(folders)), "running without demonstration"):
                folder = folders[number]
                free, motion = run_freely(folder, self.beat)
                measures = {name: measure(run) for name, run in free.items()}
                results |= {f"{folder.path}, {name}": found for name, found in measures.items()}
                content = {name: found.as_json() for name, found in measures.items()}
                write_result(folder.free_running, motion.name, {"beat_s": self.beat} | content)
                picture = folder.figures / "free_running.png"
                write_figure(picture, free[ANTICIPATION], motion)
            print(as_markdown(results))
            return picture
