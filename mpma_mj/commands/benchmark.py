"""Command `mpma benchmark`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

from mpma_mj.commands.folders import write_tables
from mpma_mj.commands.run_options import Motions, Reading
from mpma_mj.commands.workers import SweepWorkers, Workers
from mpma_mj.errors import BadOptionError
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training.config import RunConfig

__all__ = ["Benchmark"]

_BUILT_IN = "ymca"


@dataclass(frozen=True)
class Benchmark:
    """Train all agents on the YMCA and on recordings, with both kinds of arms; print one table.

    Repeat the command with the same --out to resume.
    """

    motions: Motions = ()
    """Recordings, or folders of them; each is learned separately."""
    agents: tuple[str, ...] = (
        *("mpma", "single", "adaptive", "resolved_rate", "mosaic", "hammer"),
        *("feedback_only", "open_loop", "random"),
    )
    """Agents, or paths of classes such as my_agents.py:MyAgent."""
    runs: int = 5
    """Runs of each agent, with seeds from 0."""
    nodes: int | None = None
    """Neurons of each reservoir; each agent's own default if not given."""
    epochs: int = 30
    """Largest number of epochs of a run."""
    stop: bool = True
    """End a run when it has converged; otherwise train all epochs, of which the best counts."""
    reading: Reading = ReadingOptions()
    """Options of reading recordings."""
    who: SweepWorkers = Workers()
    """Workers that train."""
    out: Path | None = None
    """Folder of the table; runs/benchmark-TIME if not given."""

    def run(self) -> Path:
        """Run the benchmark and return its folder."""
        from mpma_mj.experiments import agents as benchmark

        spec = benchmark.spec_of(self._bases(), self.agents, self.runs, self.epochs, stop=self.stop)
        with self.who.trained(spec, self.out, "benchmark", benchmark.title) as folder:
            from mpma_mj.experiments.agents_figure import write_figure

            runs = folder.finished()
            folder.write_rows(runs)
            write_figure(folder.path / "benchmark.png", benchmark.lines(spec, runs))
            tables = benchmark.as_markdown(spec, runs), benchmark.as_csv(spec, runs)
            write_tables(folder.path, "benchmark", *tables)
            return folder.path

    def _bases(self) -> list[RunConfig]:
        """Return the config of each motion; options of reading apply to recordings only."""
        from mpma_mj.training.dataset import expand_folders

        motions = expand_folders(self.motions)
        for motion in motions:
            if motions.count(motion) > 1:
                raise BadOptionError(
                    f"{motion} is given twice; each is learned separately, give it once"
                )
        recordings = [m for m in motions if m != _BUILT_IN]
        sizes = {} if self.nodes is None else {"nodes": self.nodes}
        built_in = RunConfig.of(tempo=self.reading.tempo, **sizes)
        of_recordings = dataclasses.replace(built_in, reading=self.reading)
        return [built_in, *(of_recordings.replace(motions=(m,)) for m in recordings)]
