"""What acting, learning and training cost beside the physics that is in them."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools

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

_CONFIG = RunConfig()  # 4 modules of 50 nodes, YMCA three times in a row
_RUNS = 20
_ROUNDS = 11
_MOST_EPOCHS = 20  # of a training that is stopped by its criteria long before
_LEARNING, _FROM_NOTHING = "learning the dance", "learning the dance, with what is created before"


def measure(progress: Progress) -> Report:
    """Time an agent of the usual size, and as many side by side as a sweep trains.

    Everything is per control step of one run, so that times can be compared as they stand; a whole
    training is divided by the steps of one of its epochs.

    Args:
        progress: Shows how far the rounds are.
    """
    company = f"{_RUNS} runs side by side, per run"
    floor = "bare mj_step calls, one step's worth, beside training"
    seeds = itertools.count(1)
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
            _LEARNING: _learning(),
            # Of other seeds each time, as spectral radii are remembered.
            _FROM_NOTHING: Case(lambda: _learn(_trainer(next(seeds)))),
        }
        times = in_turn(cases, progress(range(_ROUNDS), "timing training"))
    return Report(
        seconds={f"{name}, per control step": spread(times[name]) for name in cases},
        ratios={
            f"{alone} over bare mj_step calls": ratio(times[alone], times[floor], 2.5),
            f"{together}, over bare mj_step calls": ratio(times[together], times[floor], 2.0),
            **{
                f"{name}, over bare mj_step calls of an epoch": ratio(
                    times[name], times[floor], 15.0
                )
                for name in (_LEARNING, _FROM_NOTHING)
            },
        },
    )


def _epoch_alone() -> Case:
    """Return an epoch as `mpma imitate` trains: dance, refit, measures."""
    trainer = _trainer()

    def run() -> int:
        trainer.run_epoch(stop=False)
        return len(trainer.histories[0].best.trace)

    return Case(run)


def _learning() -> Case:
    """Return a training until its criteria are met, by an agent and arms that are there."""
    created: list[Trainer] = []
    return Case(lambda: _learn(created.pop()), lambda: created.append(_trainer()))


def _learn(trainer: Trainer) -> int:
    """Train until the criteria are met; return the steps of one epoch."""
    while len(trainer.going) and trainer.epoch < _MOST_EPOCHS:
        trainer.run_epoch()
    return len(trainer.histories[0].best.trace)


def _trainer(seed: int = 0) -> Trainer:
    return Trainer([dataclasses.replace(_CONFIG, seed=seed)], ymca())


def _batch() -> Trainer:
    configs = [dataclasses.replace(_CONFIG, seed=seed) for seed in range(_RUNS)]
    return Trainer(configs, ymca(), keep_states=False)


def _epoch_of(batch: Trainer, steps: int) -> Case:
    """Return an epoch as `mpma sweep` trains; runs that have converged go on."""

    def run() -> int:
        batch.run_epoch(stop=False)
        return steps

    return Case(run)
