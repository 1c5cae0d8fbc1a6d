"""`mpma compare`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.dance_video import missing_opengl
from mpma_mj.commands.folders import output_folder
from mpma_mj.commands.run_options import RunOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.training.config import RunConfig, versions

if TYPE_CHECKING:
    from mpma_mj.motions import Motion
    from mpma_mj.trials.compare import Cell

__all__ = ["Compare"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Compare(Generic[AgentT]):
    """Train on ideal arms, on simulated ones, and on those without weight; dance on each."""

    motions: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")] = ()
    """"ymca", or a recording; several, or a folder, are a repertoire that is learned together."""
    runs: int = 5
    """Runs on each kind of arms, with seeds from 0."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """What determines the result."""
    epochs: int = 30
    """Most epochs of a run; it ends when it has converged."""
    adaptation: int = 3
    """Epochs that agents learn on where they are tried."""
    workers: int | None = None
    """Processes that work at a time; as many as there are processors if not given."""
    video: bool = True
    """Make a video of all arms side by side; needs OpenGL."""
    out: Path | None = None
    """Folder of tables, figures and video, in place of those that are there; runs/compare-TIME if
    not given."""

    def run(self) -> Path:
        """Do it and return the folder."""
        missing_gl = missing_opengl() if self.video else None
        from mpma_mj.sweep.backend import open_backend
        from mpma_mj.sweep.spec import seeds
        from mpma_mj.training.dataset import read_motions
        from mpma_mj.trials import compare_figure
        from mpma_mj.trials.compare import compare, jobs
        from mpma_mj.trials.compare_table import as_csv, as_markdown
        from mpma_mj.utils.atomic_files import FORMAT, write_json, write_text
        from mpma_mj.utils.progress import show_runs

        config = self._config()
        motion = read_motions(config)
        spec = jobs(
            seeds(config, self.runs), motion, epochs=self.epochs, adaptation=self.adaptation
        )
        with output_folder(self.out, "compare") as folder:
            with (
                open_backend("processes", self.workers, None) as backend,
                show_runs(len(spec) * self.runs, 0, "training and dancing") as show,
            ):
                cells = compare(
                    spec, backend, lambda learned: show(self.runs, f"learned on {learned}")
                )
            numbers = {"runs": self.runs, "epochs": self.epochs, "adaptation": self.adaptation}
            content = {
                "format": FORMAT,
                "config": config.to_json(),
                "versions": versions(),
            }
            # Not config.json, which makes a folder a run: one that was there would be lost.
            write_json(folder / "compare.json", content | numbers)
            video = folder / "dances.mp4"
            video.unlink(missing_ok=True)  # of other dances
            markdown = as_markdown(cells, self.adaptation)
            write_text(folder / "compare.md", markdown)
            write_text(folder / "compare.csv", as_csv(cells))
            compare_figure.write_transfer(folder / "transfer.png", cells, self.adaptation)
            compare_figure.write_dances(folder / "dances.png", cells, motion)
            print(markdown)
            if missing_gl is not None:
                print(missing_gl, file=sys.stderr)
            elif self.video:
                _write_video(video, cells, motion)
            return folder

    def _config(self) -> RunConfig:
        from mpma_mj.training.dataset import expand_folders

        if not self.motions:
            raise BadOptionError("no motion given; try: mpma compare ymca")
        return self.options.run_config(expand_folders(self.motions))


def _write_video(path: Path, cells: Sequence[Cell], motion: Motion) -> None:
    from mpma_mj.trials.compare_figure import first_dances
    from mpma_mj.trials.compare_video import write_side_by_side
    from mpma_mj.utils.progress import show_frames

    dances = first_dances(cells)
    if dances:  # else all have diverged, as the table says
        write_side_by_side(path, dances, motion, show_frames)
