"""What training costs beside the physics that is in it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mpma_mj.bench.environment import bare_rollout
from mpma_mj.bench.timing import in_turn
from mpma_mj.experiments.folder import RunResult

__all__ = ["ROUNDS", "beside_bare_physics"]

ROUNDS = 21
"""How often bare physics is timed; its median counts."""


def beside_bare_physics(
    seconds: float, runs: Sequence[RunResult], threads: int, rounds: Iterable[int]
) -> str:
    """Say how long training took, and how long its physics takes alone.

    Args:
        seconds: How long the training of the runs took, s.
        runs: The runs; those that diverged are not counted, so that the ratio is not too good.
        threads: On how many threads bare physics is timed.
        rounds: Numbers of the rounds of timing.
    """
    measured = [run.summary for run in runs if not run.diverged]
    steps = sum(summary["environment_steps"] for summary in measured)
    epochs = sum(summary["epochs"] for summary in measured)
    times = in_turn({"bare": bare_rollout(threads)}, rounds)["bare"]
    bare = float(np.median(times)) * steps
    return (
        f"Training took {seconds:.3g} s, {1000 * seconds / epochs:.3g} ms an epoch; bare physics"
        f" of the same {epochs} epochs, `mujoco.rollout` on {threads} thread(s), takes"
        f" {bare:.3g} s, {1000 * bare / epochs:.3g} ms an epoch: {seconds / bare:.2f} times as"
        " much."
    )
