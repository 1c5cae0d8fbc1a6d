"""What is sent to a worker, and what it does with it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from mpma_mj.errors import WorkerError
from mpma_mj.motions import Motion
from mpma_mj.sweep.backend import Work
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.trainer import train_batch

__all__ = ["Job", "JobResult"]


@dataclass(frozen=True, eq=False)
class Job(Work):
    """Runs that are trained side by side.

    Attributes:
        configs: Their settings, which differ in the seed only.
        motion: What they imitate; it travels along, so that workers need no recording.
        epochs: Most epochs of a run.
        stop: Whether a run ends when it has converged.
        versions: Of what computes the results, where the work was asked for.
    """

    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int
    stop: bool
    versions: dict[str, str]

    def do(self) -> JobResult:
        """Train and return what came of it.

        Raises:
            WorkerError: The worker would compute other results than the one who spec.
            MpmaError: The settings do not fit.
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
    """What came of a job.

    Attributes:
        summaries: A summary of each run.
        seconds: How long it took, for each run its equal share, s.
    """

    summaries: list[dict[str, Any]]
    seconds: float
