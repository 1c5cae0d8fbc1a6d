"""Train a movement, or a repertoire, with many seeds and print what came of it, as Markdown.

python benchmarks/seeds.py ymca --seeds 20
python benchmarks/seeds.py ymca --seeds 20 --rule gated --nodes 100 --epochs 25
"""

from __future__ import annotations

import dataclasses
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import tyro

from mpma_mj.training.config import RunConfig, Settings
from mpma_mj.training.imitate import start
from mpma_mj.training.run_folder import RunFolder

MEASURES = ("epochs", "p_e_percent", "feedback_ratio", "rp_error_percent", "nmi", "modules_used")


def main(
    motions: tyro.conf.Positional[tuple[str, ...]] = ("ymca",),
    settings: tyro.conf.OmitArgPrefixes[Settings] = Settings(),  # noqa: B008, frozen
    seeds: int = 20,
    epochs: int = 30,
) -> None:
    """Train and print a row for every seed, then medians and counts.

    Args:
        motions: What is imitated; several are a repertoire.
        settings: Settings; the seed is the first of the seeds.
        seeds: Number of seeds.
        epochs: Most epochs of a run.
    """
    print("| seed | converged | " + " | ".join(MEASURES) + " | active modules | seconds |")
    print("|---" * (len(MEASURES) + 4) + "|")
    summaries = []
    for seed in range(settings.seed, settings.seed + seeds):
        values = dataclasses.asdict(settings) | {"seed": seed}
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            run = RunFolder(Path(folder) / "run")
            summary = start(RunConfig(motions=motions, **values), run, epochs)
        summaries.append(summary | {"seconds": time.perf_counter() - began})
        print(_row(str(seed), summaries[-1]), flush=True)
    print(_totals(summaries))


def _row(name: str, summary: dict[str, Any]) -> str:
    measures = " | ".join(f"{summary[measure]:.4g}" for measure in MEASURES)
    active = " ".join(f"{label} {count}" for label, count in summary["active_modules"].items())
    converged = "yes" if summary["converged"] else "no"
    return f"| {name} | {converged} | {measures} | {active} | {summary['seconds']:.2f} |"


def _totals(summaries: list[dict[str, Any]]) -> str:
    median = {m: statistics.median(s[m] for s in summaries) for m in (*MEASURES, "seconds")}
    converged = sum(s["converged"] for s in summaries)
    three = sum(s["modules_used"] >= 3 for s in summaries)
    one_to_three = sum(
        s["converged"] and all(1 <= n <= 3 for n in s["active_modules"].values()) for s in summaries
    )
    numbers = ", ".join(f"{name} {value:.4g}" for name, value in median.items())
    worst = max(s["p_e_percent"] for s in summaries)
    return (
        f"\nConverged: {converged} of {len(summaries)}; with 1 to 3 active modules for every"
        f" label: {one_to_three}; with 3 or more modules used: {three}.\nMedians: {numbers}."
        f" Largest p_e_percent: {worst:.4g}."
    )


if __name__ == "__main__":
    tyro.cli(main)
