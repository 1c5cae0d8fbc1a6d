"""Imitate recordings, each alone, and print the results as Markdown.

python benchmarks/recordings.py FOLDER/*/*.bvh FOLDER/*/*.c3d --seeds 3 --tempos 1 1.5 2
"""

from __future__ import annotations

import dataclasses
import itertools
import warnings
from pathlib import Path

import tyro

from mpma_mj.agents import MPMAConfig
from mpma_mj.commands.run_options import RunOptions, registry
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import MpmaError, RecordingWarning
from mpma_mj.motions.feasible_motion import feasible
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.trainer import train_batch


def main(
    motions: tyro.conf.Positional[tuple[str, ...]],
    options: tyro.conf.OmitArgPrefixes[RunOptions[MPMAConfig]],
    seeds: int = 3,
    epochs: int = 30,
    tempos: tuple[float, ...] = (1.0,),
) -> None:
    """Train each recording with some seeds at each tempo and print a row for it.

    Args:
        motions: The recordings.
        options: Options of all runs; the seed is the first of the seeds.
        seeds: Number of seeds.
        epochs: Most epochs of a run.
        tempos: Tempos.
    """
    warnings.simplefilter("ignore", RecordingWarning)
    print("| recording | tempo | changed | converged | epochs | plants | p_e, % | feedback ratio |")
    print("|---|---|---|---|---|---|---|---|")
    for source, tempo in itertools.product(motions, tempos):
        title = f"| {Path(source).name} | {tempo:g} |"
        config = options.run_config((source,), "imitate").replace(tempo=tempo)
        try:
            print(title, _row(config, seeds, epochs), flush=True)
        except MpmaError as error:
            reason = str(error).replace(source, "").lstrip(": ").replace("|", "/")
            print(title, f"refused: {reason} | | | | | |", flush=True)


def _row(config: RunConfig, seeds: int, epochs: int) -> str:
    motion = read_motions(config)
    change = feasible(dataclasses.replace(motion, feasible_angles=None), arm_limits(config.env))[1]
    configs = [config.replace(seed=seed) for seed in range(config.seed, config.seed + seeds)]
    summaries = train_batch(configs, motion, epochs)
    cells = ["–"]
    if change is not None:
        cells = [f"{100 * change.changed:.1f} % of the steps, {change.largest:.1f}° at most"]
    cells += [
        f"{sum(summary['converged'] for summary in summaries)} of {seeds}",
        *(
            ", ".join(f"{summary[name]:.3g}" for summary in summaries)
            for name in ("epochs", "plants", "p_e_percent", "feedback_ratio")
        ),
    ]
    return f"{' | '.join(cells)} |"


if __name__ == "__main__":
    with registry():
        tyro.cli(main)
