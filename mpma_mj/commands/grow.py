"""`mpma grow`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Generic, TypeVar

import tyro

from mpma_mj.agents.config import AgentConfig
from mpma_mj.commands.folders import output_folder
from mpma_mj.commands.run_options import RunOptions
from mpma_mj.commands.workers import Workers, require_all
from mpma_mj.utils.names import printable

__all__ = ["Grow"]

AgentT = TypeVar("AgentT", bound=AgentConfig)


@dataclass(frozen=True, kw_only=True)
class Grow(Generic[AgentT]):
    """Let agents grow from one module, and compare where they settle with fixed numbers.

    Started again with the same --out it goes on where it was.
    """

    motions: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")] = (
        "ymca",
    )
    """What is imitated, as of `mpma imitate`."""
    most: int = 8
    """Most modules."""
    runs: int = 10
    """Runs that grow, and runs of each fixed number, with seeds from --seed up."""
    options: Annotated[tyro.conf.OmitArgPrefixes[RunOptions[AgentT]], tyro.conf.arg(name="")]
    """What determines the result."""
    epochs: int = 100
    """Most epochs of a run; it ends when it has converged."""
    who: tyro.conf.OmitArgPrefixes[Workers] = dataclasses.field(default_factory=Workers)
    """Who trains."""
    out: Path | None = None
    """Folder of the runs; runs/grow-TIME if not given."""

    def run(self) -> Path:
        """Do it and return the folder."""
        from mpma_mj.sweep.folder import SweepFolder
        from mpma_mj.sweep.growth import as_markdown, spec_of
        from mpma_mj.training.dataset import expand_folders
        from mpma_mj.utils.atomic_files import write_text

        base = self.options.run_config(expand_folders(self.motions))
        spec = spec_of(self.most, self.runs, base, self.epochs)
        with output_folder(self.out, "grow") as path:
            folder = SweepFolder(path, spec)
            self.who.train(folder)
            from mpma_mj.sweep.growth_figure import write_figure

            runs = folder.finished()
            table = as_markdown(spec, runs)
            folder.write_rows(runs)
            write_text(folder.path / "growth.md", table)
            title = ", ".join(printable(Path(motion).stem) for motion in base.motions)
            write_figure(folder.path / "growth.png", runs, title)
            print(table)
            require_all(folder)
            return folder.path
