"""What acting, learning and training cost beside the physics that is in them."""

from __future__ import annotations

import contextlib
import dataclasses

from mpma_mj.bench.environment import bare_steps
from mpma_mj.bench.rehearsal import Rehearsal
from mpma_mj.bench.report import Report
from mpma_mj.bench.timing import Case, Progress, in_turn, ratio, spread
from mpma_mj.envs.load import load
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import one_thread
from mpma_mj.training.trainer import Trainer

__all__ = ["measure"]

_CONFIG = RunConfig()  # 4 modules of 200 nodes, YMCA three times in a row
_RUNS = 20
_ROUNDS = 11


def measure(progress: Progress) -> Report:
    """Time an agent of the usual size, and as many side by side as a sweep trains.

    Everything is per control step of one run, so that times can be compared as they stand.

    Args:
        progress: Shows how far the rounds are.
    """
    company = f"{_RUNS} runs side by side, per run"
    floor = "bare mj_step calls, one step's worth, beside training"
    alone, together = "a training epoch", f"a training epoch, {company}"
    with one_thread(), contextlib.closing(_batch()) as batch:
        one, many = Rehearsal.alone(_CONFIG), Rehearsal.side_by_side(_CONFIG, _RUNS)
        cases = {
            floor: bare_steps(load()),
            "act and observe": one.acts,
            f"act and observe, {company}": many.acts,
            "refit": one.learns,
            f"refit, {company}": many.learns,
            alone: _epoch_alone(),
            together: _epoch_of(batch, many.steps),
        }
        times = in_turn(cases, progress(range(_ROUNDS), "timing training"))
    return Report(
        seconds={f"{name}, per control step": spread(times[name]) for name in cases},
        ratios={
            f"{alone} over bare mj_step calls": ratio(times[alone], times[floor], 2.5),
            f"{together}, over bare mj_step calls": ratio(times[together], times[floor], 2.0),
        },
    )


def _epoch_alone() -> Case:
    """Return an epoch as `mpma imitate` trains: dance, refit, measures."""
    trainer = Trainer([_CONFIG], ymca())

    def run() -> int:
        trainer.run_epoch(stop=False)
        return len(trainer.histories[0].best.trace)

    return Case(run)


def _batch() -> Trainer:
    configs = [dataclasses.replace(_CONFIG, seed=seed) for seed in range(_RUNS)]
    return Trainer(configs, ymca(), keep_states=False)


def _epoch_of(batch: Trainer, steps: int) -> Case:
    """Return an epoch as `mpma sweep` trains; runs that have converged go on."""

    def run() -> int:
        batch.run_epoch(stop=False)
        return steps

    return Case(run)
