"""Command `mpma capture`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from mpma_mj.commands.folders import write_result

__all__ = ["Capture"]


@dataclass(frozen=True)
class Capture:
    """Analyse what each module of a trained run captures: tables, JSON and a figure."""

    run_folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Folder of the run."""

    def run(self) -> Path:
        """Analyse the run and return the path of the figure."""
        from mpma_mj.analysis.epoch_trace import read_danced
        from mpma_mj.analysis.modules import analyse
        from mpma_mj.analysis.modules_figure import write_figure
        from mpma_mj.analysis.modules_table import tables
        from mpma_mj.training.run_folder import RunFolder
        from mpma_mj.utils.progress import show_range

        folder = RunFolder(self.run_folder)
        with folder.locked():
            danced = read_danced(folder)
            captured = analyse(
                danced.trace,
                danced.motion.labels,
                danced.period,
                lambda factors: show_range(factors, "looking for synergies"),
            )
            write_result(folder.capture, danced.motion.name, captured.as_json())
            picture = folder.figures / "capture.png"
            write_figure(picture, captured, danced.motion)
            print(tables(captured) + "\n")
            return picture
