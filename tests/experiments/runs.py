"""Small sweeps, records that were never measured, and commands in a process of their own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Self

from mpma_mj.experiments.backend import Work
from mpma_mj.experiments.records import Record
from mpma_mj.experiments.sweep import Sweep
from mpma_mj.experiments.training import TrainingStudy
from mpma_mj.training.config import RunConfig

TINY = RunConfig.of(nodes=5, modules=2, repeats=1)
TINY_WORDS = ("--nodes", "5", "--modules", "2", "--repeats", "1", "--epochs", "2")


def sweep_of(*grid: str, runs: int = 2, epochs: int = 2) -> Sweep:
    return Sweep(grid=grid, base=TINY, runs=runs, epochs=epochs)


def finished(labels: dict[str, Any], seed: int = 0, **summary: Any) -> Record:
    """Return a record with measures that were never measured."""
    measures = {
        "agent": "mpma",
        "diverged": False,
        "seconds": 0.5,
        "epochs": 7,
        "converged": True,
        "p_e_percent": 0.5,
        "feedback_ratio": 0.04,
        "learned_share": 0.3,
        "nmi": 0.9,
        "modules_used": 2,
        "active_modules": {"Y": 1, "M": 2, "C": 2, "A": 1},
        "repeatability": {"responsibility": 0.99, "module_output": None},
        "environment_steps": 7 * 227,
        "attempts": 1,
    }
    return measures | labels | {"seed": seed} | summary


def diverged(labels: dict[str, Any], seed: int = 0) -> Record:
    """Return the record of a run that diverged."""
    record = {"agent": "mpma", **labels, "seed": seed, "diverged": True, "attempts": 1}
    return record | {"failed": "diverged, at step 3", "seconds": 0.5}


def labels_of(study: TrainingStudy) -> Iterator[tuple[dict[str, Any], int]]:
    """Yield labels and seed of all runs of a study."""
    for labels, config in study.points():
        for seed in range(config.seed, config.seed + study.runs):
            yield dict(labels), seed


class Here:
    """A backend that does the work itself, and loses its first jobs."""

    workers = 2

    def __init__(self, losses: int = 0) -> None:
        self.losses = losses
        self.jobs: deque[Work] = deque()
        self.most = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def submit(self, work: Work) -> None:
        self.jobs.append(work)
        self.most = max(self.most, len(self.jobs))

    def next_done(self) -> tuple[Work, Any]:
        work = self.jobs.popleft()
        self.losses -= 1
        return work, None if self.losses >= 0 else work.do()


def mpma(*words: object, **options: Any) -> subprocess.Popen[str]:
    """Start the command in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "mpma_mj.cli", *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def environment(**variables: str) -> dict[str, str]:
    return os.environ | variables


def run_files(folder: Path) -> list[Path]:
    # What is still being written has a name that begins with a dot.
    return sorted((folder / "runs").glob("[!.]*.json"))


def table_rows(table: str) -> Sequence[list[str]]:
    """Return the cells of all rows of tables in Markdown."""
    lines = (line for line in table.splitlines() if line.startswith("| "))
    return [line.strip("| ").split(" | ") for line in lines]
