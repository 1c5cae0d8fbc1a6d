"""Imitate recordings, each alone, and print the results as Markdown.

python benchmarks/recordings.py FOLDER/*/*.bvh FOLDER/*/*.c3d --seeds 3
"""

from __future__ import annotations

import tempfile
import warnings
from pathlib import Path

import tyro

from mpma_mj.agents import MPMAConfig
from mpma_mj.commands.run_options import RunOptions, registry
from mpma_mj.errors import MpmaError, RecordingWarning
from mpma_mj.training.run import train
from mpma_mj.training.run_folder import RunFolder


def main(
    motions: tyro.conf.Positional[tuple[str, ...]],
    options: tyro.conf.OmitArgPrefixes[RunOptions[MPMAConfig]],
    seeds: int = 3,
    epochs: int = 30,
) -> None:
    """Train each recording with some seeds and print a row for it.

    Args:
        motions: The recordings.
        options: Options of all runs; the seed is the first of the seeds.
        seeds: Number of seeds.
        epochs: Most epochs of a run.
    """
    warnings.simplefilter("ignore", RecordingWarning)
    print("| recording | converged | epochs | p_e, % | feedback ratio |")
    print("|---|---|---|---|---|")
    for motion in motions:
        try:
            print(_row(motion, options, seeds, epochs), flush=True)
        except MpmaError as error:
            reason = str(error).replace(motion, "").lstrip(": ").replace("|", "/")
            print(f"| {Path(motion).name} | refused: {reason} | | | |", flush=True)


def _row(motion: str, options: RunOptions[MPMAConfig], seeds: int, epochs: int) -> str:
    summaries = []
    point = options.run_config((motion,), "imitate")
    for seed in range(point.seed, point.seed + seeds):
        config = point.replace(seed=seed)
        with tempfile.TemporaryDirectory() as folder:
            run = train(config, epochs, folder=RunFolder(Path(folder) / "run"))
            summaries.append(run.summary)
    cells = [
        Path(motion).name,
        f"{sum(summary['converged'] for summary in summaries)} of {seeds}",
        *(", ".join(f"{s[name]:.3g}" for s in summaries) for name in ("epochs", "p_e_percent")),
        ", ".join(f"{summary['feedback_ratio']:.2g}" for summary in summaries),
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    with registry():
        tyro.cli(main)
