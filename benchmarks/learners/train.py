"""Let every learner train on YMCA and write its learning curve, p_e over environment steps.

python benchmarks/learners/train.py --out curves.csv
python benchmarks/learners/train.py MPMA "CMA-ES + feedback" --seeds 10 --out curves.csv
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

# Nothing is drawn, and OpenGL in software does not get on with PyTorch's compiler.
os.environ["MUJOCO_GL"] = "disable"

import tyro
from curves import Row, read_curves, replace_curves, write_curves
from threadpoolctl import threadpool_limits

from mpma_mj.options import Arms

FIXED = ("random", "open loop", "feedback only", "by hand")
TRAINED = {
    "MPMA": ("modules", {}),
    "BC": ("modules", {"agent": "bc"}),
    "DAgger": ("modules", {"agent": "dagger"}),
    "CMA-ES": ("evolution", {"assisted": False}),
    "CMA-ES + feedback": ("evolution", {"assisted": True}),
    "PPO": ("ppo", {"assisted": False}),
    "PPO + feedback": ("ppo", {"assisted": True}),
}
NEEDED = {"evolution": "cma", "ppo": "stable_baselines3"}


def main(
    learners: tyro.conf.Positional[tuple[str, ...]] = (*FIXED, *TRAINED),
    arms: Arms = "physics",
    seeds: int = 5,
    mpma_steps: int = 50_000,
    cma_steps: int = 2_000_000,
    ppo_steps: int = 200_000,
    out: Path = Path("curves.csv"),
) -> None:
    """Train and measure; runs that are in the file already are replaced.

    Args:
        learners: Names of learners; all of them if none is given.
        arms: Simulated arms or arms that move ideally.
        seeds: Number of seeds, from 0.
        mpma_steps: Environment steps of MPMA.
        cma_steps: Environment steps of CMA-ES.
        ppo_steps: Environment steps of PPO.
        out: CSV file of the curves.
    """
    check(learners)
    steps = {"modules": mpma_steps, "evolution": cma_steps, "ppo": ppo_steps}
    with threadpool_limits(1, user_api="blas"):
        for learner in learners:
            train = trainer(learner, arms, steps)
            for seed in range(seeds):
                rows = []
                for danced, p_e in train(seed):
                    rows.append(Row(learner, seed, danced, p_e))
                    print(f"{learner}, seed {seed}, {danced:,} steps: p_e {p_e:.2f} %", flush=True)
                write_curves(out, replace_curves(read_curves(out), rows))


def check(learners: tuple[str, ...]) -> None:
    """End with one line if a learner is not known or its package is missing."""
    for learner in learners:
        if learner not in (*FIXED, *TRAINED):
            sys.exit(f"no learner '{learner}'; expected {', '.join((*FIXED, *TRAINED))}")
        package = NEEDED.get(TRAINED[learner][0]) if learner in TRAINED else None
        if package and importlib.util.find_spec(package) is None:
            sys.exit(f"{learner} needs {package}: pip install -e '.[sb3,cma]'")


def trainer(learner: str, arms: Arms, steps: dict[str, int]) -> Callable[[int], Any]:
    """Return what trains a learner with a seed; imports no package that it does not need."""
    if learner in FIXED:
        return partial(importlib.import_module("fixed").dance, learner, arms=arms)
    name, options = TRAINED[learner]
    return partial(importlib.import_module(name).learn, arms=arms, steps=steps[name], **options)


if __name__ == "__main__":
    tyro.cli(main)
