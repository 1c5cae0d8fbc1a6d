"""What is sent to a worker, and what it does with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpma_mj.errors import WorkerError
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.crowd import train_crowd

__all__ = ["Job", "Summaries", "do"]

Summaries = list[dict[str, Any]]


@dataclass(frozen=True, eq=False)
class Job:
    """Runs that are trained side by side.

    Attributes:
        configs: Their settings, which differ in the seed only.
        motion: What they imitate; it travels along, so that workers need no recording.
        epochs: Most epochs of a run.
        versions: Of what computes the results, where the work was asked for.
        tries: How often it was begun, this time included.
    """

    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int
    versions: dict[str, str]
    tries: int = 1


def do(job: Job) -> Summaries:
    """Train and return a summary for each run.

    Raises:
        WorkerError: The worker would compute other results than the one who asked.
        MpmaError: The settings do not fit.
    """
    here = versions()
    for package, version in job.versions.items():
        if here[package] != version:
            raise WorkerError(
                f"a worker has {package} {here[package]}, the command {version}; install the same"
            )
    return train_crowd(job.configs, job.motion, job.epochs)
