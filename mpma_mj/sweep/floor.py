"""What training costs beside the physics that is in it."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Sequence

import mujoco
import numpy as np
from mujoco import rollout

from mpma_mj.envs.arm_batch import chunk_size
from mpma_mj.envs.load import load
from mpma_mj.sweep.folder import RunResult

__all__ = ["ROUNDS", "bare_rollout", "beside_bare_physics"]

ROUNDS = 21
"""How often bare physics is timed; its median counts."""

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


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
    simulate = bare_rollout(threads)
    simulate()  # warms up
    bare = statistics.median(_seconds_of_a_step(simulate) for _ in rounds) * steps
    return (
        f"Training took {seconds:.3g} s, {1000 * seconds / epochs:.3g} ms an epoch; bare physics"
        f" of the same {epochs} epochs, `mujoco.rollout` on {threads} thread(s), takes"
        f" {bare:.3g} s, {1000 * bare / epochs:.3g} ms an epoch: {seconds / bare:.2f} times as"
        " much."
    )


def _seconds_of_a_step(simulate: Callable[[], int]) -> float:
    began = time.perf_counter()
    steps = simulate()
    return (time.perf_counter() - began) / steps


def bare_rollout(threads: int, members: int = 64, steps: int = 20) -> Callable[[], int]:
    """Return a simulation of arms under random commands, with all that makes it fast.

    Args:
        threads: How many simulate at a time.
        members: Number of pairs of arms.
        steps: Control steps of each.

    Returns:
        Function that simulates from the start and returns the control steps of all pairs.
    """
    env = load()
    model = env.physics.model.ptr
    nstep = round(env.control_timestep() / env.physics.timestep())
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, members, model.nu))
    controls = actions * env.task.max_joint_speed
    size = mujoco.mj_stateSize(model, _STATE)
    begin, trajectory = np.zeros((members, size)), np.zeros((members, nstep, size))
    for row in begin:
        env.reset()
        row[:] = env.physics.get_state(_STATE)
    applied = np.zeros((members, nstep, model.nu))
    models, data = [model] * members, [mujoco.MjData(model) for _ in range(threads)]
    pool = rollout.Rollout(nthread=threads)

    def simulate() -> int:
        state = begin
        for control in controls:
            applied[:] = control[:, None]
            pool.rollout(
                models,
                data,
                state,
                applied,
                skip_checks=True,
                nstep=nstep,
                state=trajectory,
                chunk_size=chunk_size(members, threads),
            )
            state = trajectory[:, -1].copy()
        return steps * members

    return simulate
