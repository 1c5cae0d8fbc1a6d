"""Jobs of a sweep: batches of runs that a worker trains, and their results."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from mpma_mj.errors import WorkerError
from mpma_mj.experiments.backend import Work
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.trainer import train_batch

__all__ = ["Job", "JobResult"]


@dataclass(frozen=True, eq=False)
class Job(Work):
    """A batch of runs.

    Attributes:
        configs: Config of each run; they differ in their seeds only.
        motion: The motion; it is sent along, so that workers need no recording.
        epochs: Largest number of epochs of a run.
        stop: Whether a run ends when it has converged.
        versions: Versions of the packages that determine the results, on the requesting machine.
    """

    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int
    stop: bool
    versions: dict[str, str]

    def do(self) -> JobResult:
        """Train the batch and return the results.

        Raises:
            WorkerError: The worker has another version of a package, and would compute other
                results.
            MpmaError: The config does not fit the motion.
        """
        here = versions()
        for package, version in self.versions.items():
            if here[package] != version:
                raise WorkerError(
                    f"a worker has {package} {here[package]}, the command {version}; install the"
                    " same"
                )
        began = time.perf_counter()
        summaries = train_batch(self.configs, self.motion, self.epochs, stop=self.stop)
        return JobResult(summaries, (time.perf_counter() - began) / len(summaries))


@dataclass(frozen=True)
class JobResult:
    """Result of a job.

    Attributes:
        summaries: Summary of each run.
        seconds: Duration of the job divided by its number of runs, s.
    """

    summaries: list[dict[str, Any]]
    seconds: float
