"""Learn a motion after another one, and print p_e of each epoch as a Markdown table.

python benchmarks/learning_on.py ymca dance.tsv
"""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import tyro
from numpy.typing import NDArray

from mpma_mj.metrics import posture_error_percent
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import TrainedAgents, load_state
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.factory import make_environments, one_thread
from mpma_mj.training.history import TrainingHistory
from mpma_mj.training.rollout import rollout
from mpma_mj.training.trainer import Trainer, train_agents
from mpma_mj.utils.text import markdown_table

Array = NDArray[np.float64]


def main(first: str, second: str, /, runs: int = 5, epochs: int = 3) -> None:
    """Train runs on the first motion until they have converged, then on the second one.

    Args:
        first: The motion that is learned first.
        second: The motion that is learned after it, and from nothing.
        runs: Number of seeds.
        epochs: Epochs on the second motion, in which no run stops.
    """
    before, after = (
        [RunConfig.of(motion, seed=seed) for seed in range(runs)] for motion in (first, second)
    )
    motions = [read_motions(configs[0]) for configs in (before, after)]
    with one_thread():
        learned = train_agents(before, motions[0], 30, {})
        nothing, _ = train_from(None, after, motions[1], epochs)
        on, state = train_from(learned.state, after, motions[1], epochs)
        kept = [p_e_of(agents) for agents in (learned, replace(learned, state=state))]
    head = ["p_e, %", *(f"epoch {epoch + 1}" for epoch in range(epochs)), "plants found"]
    names = [Path(motion).stem for motion in (first, second)]
    rows = {f"{names[1]} after {names[0]}": on, f"{names[1]} from nothing": nothing}
    print(markdown_table(head, [[name, *cells(histories)] for name, histories in rows.items()]))
    print(f"\n{names[0]}, nothing learned from it again: before {cell(kept[0])},", end=" ")
    print(f"after {epochs} epochs on {names[1]} {cell(kept[1])}")


def train_from(
    state: dict[str, Array] | None, configs: list[RunConfig], motion: Motion, epochs: int
) -> tuple[list[TrainingHistory], dict[str, Array]]:
    """Train runs from a state, or from nothing; return their histories and their agents' state."""
    trainer = Trainer(configs, motion)
    with contextlib.closing(trainer):
        if state is not None:
            load_state(trainer.agent, state, None)
        trainer.run(epochs, stop=False)
    return trainer.histories, trainer.agent.state_dict()


def p_e_of(agents: TrainedAgents) -> Array:
    """Return p_e of agents in an episode of their motion, shape (R,), percent."""
    env = make_environments(agents.configs[0], agents.seeds, agents.motion)
    with contextlib.closing(env):
        trace = rollout(env, agents.agent(env), 0).trace
    traces = [trace.of_run(run) for run in range(len(agents.seeds))]
    return np.array([posture_error_percent(t.posture[1:], t.reference[1:]) for t in traces])


def cells(histories: list[TrainingHistory]) -> list[str]:
    """Return p_e of each epoch and the number of plants found, over runs."""
    p_e = np.array([[row["p_e_percent"] for row in history.rows] for history in histories])
    plants = (f"{history.rows[-1]['plants']:.0f}" for history in histories)
    return [*map(cell, p_e.T), ", ".join(plants)]


def cell(p_e: Array) -> str:
    """Return mean and deviation over runs."""
    return f"{p_e.mean():.2f} ± {p_e.std(ddof=1):.2f}"


if __name__ == "__main__":
    tyro.cli(main)
