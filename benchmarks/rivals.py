"""Train every agent of the repository on YMCA and print what came of it, as Markdown.

python benchmarks/rivals.py
python benchmarks/rivals.py --agents mosaic hammer --seeds 10 --arms kinematic --no-stop
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import tyro
from threadpoolctl import threadpool_limits

import mpma_mj
from mpma_mj import metrics
from mpma_mj.agents import AGENTS
from mpma_mj.options import Arms
from mpma_mj.training.course import has_converged
from mpma_mj.training.trace import record_epoch
from mpma_mj.training.trainer import Trainer

MEASURES = ("epochs", "p_e_percent", "feedback_ratio", "nmi", "modules_used", "seconds")


def main(
    agents: tuple[str, ...] = tuple(AGENTS),
    arms: tuple[Arms, ...] = ("physics", "kinematic"),
    seeds: int = 5,
    epochs: int = 30,
    modules: int = 4,
    nodes: int = 200,
    stop: bool = True,
) -> None:
    """Train and print a row for every agent and kind of arms: medians over the seeds.

    Args:
        agents: Names of agents.
        arms: Kinds of arms.
        seeds: Number of seeds, from 0.
        epochs: Most epochs of a run.
        modules: Number of modules of agents that may choose.
        nodes: Neurons of each reservoir.
        stop: Whether training ends when it has converged; if not, the best epoch counts.
    """
    config = mpma_mj.MPMAConfig(modules=modules, nodes=nodes)
    print("| arms | agent | converged | " + " | ".join(MEASURES) + " | p_e of every seed |")
    print("|---" * (len(MEASURES) + 4) + "|")
    for kind in arms:
        for name in agents:
            runs = [run(name, kind, seed, epochs, config, stop=stop) for seed in range(seeds)]
            print(f"| {kind} | {name} | {_row(runs)} |", flush=True)


def run(
    name: str, arms: Arms, seed: int, epochs: int, config: mpma_mj.MPMAConfig, *, stop: bool
) -> dict[str, Any]:
    """Train one agent; what does not learn dances one epoch. Return its measures by name."""
    env = mpma_mj.load("ymca", arms=arms, seed=seed)
    began = time.perf_counter()
    agent = mpma_mj.make_agent(env, config, kind=name, seed=seed)
    if agent.state_dict():
        trainer = Trainer(env, agent)
        while len(trainer.rows) < epochs and not (stop and trainer.converged):
            trainer.run_epoch()
        measures = trainer.summary() | {"converged": any(map(has_converged, trainer.rows))}
    else:
        trace = record_epoch(env, agent, 0)
        p_e = metrics.posture_error_percent(trace["posture"][1:], trace["reference"][1:])
        measures = {"p_e_percent": p_e}
        if "feedback" in trace:
            measures["feedback_ratio"] = metrics.feedback_ratio(trace["feedback"], trace["action"])
    return measures | {"seconds": time.perf_counter() - began}


def _row(runs: list[dict[str, Any]]) -> str:
    converged = "–"
    if "converged" in runs[0]:
        converged = f"{sum(r['converged'] for r in runs)} of {len(runs)}"
    medians = [
        f"{statistics.median(r[measure] for r in runs):.3g}" if measure in runs[0] else "–"
        for measure in MEASURES
    ]
    every = " ".join(f"{r['p_e_percent']:.3g}" for r in runs)
    return " | ".join([converged, *medians, every])


if __name__ == "__main__":
    with threadpool_limits(1, user_api="blas"):
        tyro.cli(main)
