"""Sweeps that are over in an instant, and what several tests ask of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from mpma_mj.experiments.folder import RunResult, SweepFolder
from mpma_mj.experiments.grid import points
from mpma_mj.experiments.spec import SweepSpec, seeds
from mpma_mj.training.config import RunConfig

TINY = RunConfig.of(nodes=5, modules=2, repeats=1)
TINY_WORDS = ("--nodes", 5, "--modules", 2, "--repeats", 1, "--epochs", 2)


def spec_of(*grid: str, runs: int = 2, epochs: int = 2) -> SweepSpec:
    configs = [run for point in points(grid, TINY) for run in seeds(point, runs)]
    return SweepSpec(tuple(configs), epochs)


def finished(config: RunConfig, attempts: int = 1, **summary: Any) -> RunResult:
    """Return a run with measures that were never measured."""
    measures = {
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
    }
    return RunResult(config, measures | summary, attempts, 0.5)


def results(folder: SweepFolder) -> dict[RunConfig, dict[str, Any]]:
    return {run.config: run.summary for run in folder.finished()}


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
