"""What acting, learning and training cost beside the physics that is in them."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any
from unittest import mock

from benchmarks.speed.environment import bare_steps
from benchmarks.speed.timing import Case, Report, Sizes, in_turn, ratio
from mpma_mj.envs.load import load
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.rollout import rollout
from mpma_mj.training.trainer import Trainer

__all__ = ["Rehearsal", "measure"]

_MOST_EPOCHS = 20  # of a training that is stopped by its criteria long before
_FLOOR = "bare mj_step calls, one step's worth, beside training"
_EPOCH, _LEARNING = "a training epoch", "learning the dance"
_FROM_NOTHING = "learning the dance, with what is created before"


def measure(sizes: Sizes) -> Report:
    """Time an agent of the usual size, and as many side by side as a sweep trains.

    Everything is per control step of one run, so that times can be compared as they stand; a whole
    training is divided by the steps of one of its epochs.
    """
    config, seeds = RunConfig.of(nodes=sizes.nodes), itertools.count(1)
    many_runs = f"{sizes.runs} runs side by side, per run"
    created: list[Trainer] = []
    with one_thread(), contextlib.closing(_trainer(config, range(sizes.runs))) as batch:
        one, many = Rehearsal(config), Rehearsal(config, sizes.runs)
        cases = {
            _FLOOR: bare_steps(load()),
            "act and observe": one.acts,
            f"act and observe, {many_runs}": many.acts,
            "refit": one.learns,
            f"refit, {many_runs}": many.learns,
            _EPOCH: _epochs(_trainer(config, [0]), one.steps),
            f"{_EPOCH}, {many_runs}": _epochs(batch, many.steps),
            _LEARNING: Case(
                lambda: _learn(created.pop(), one.steps),
                lambda: created.append(_trainer(config, [0])),
            ),
            # Of other seeds each time, as spectral radii are remembered.
            _FROM_NOTHING: Case(lambda: _learn(_trainer(config, [next(seeds)]), one.steps)),
        }
        times = in_turn("timing training", cases, sizes.rounds)
    wanted = {
        f"{_EPOCH} over bare mj_step calls": (_EPOCH, 2.5),
        f"{_EPOCH}, {many_runs}, over bare mj_step calls": (f"{_EPOCH}, {many_runs}", 2.0),
        f"{_LEARNING}, over bare mj_step calls of an epoch": (_LEARNING, 15.0),
        f"{_FROM_NOTHING}, over bare mj_step calls of an epoch": (_FROM_NOTHING, 15.0),
    }
    return Report(
        {f"{name}, per control step": values for name, values in times.items()},
        {title: ratio(times[of], times[_FLOOR], most) for title, (of, most) in wanted.items()},
    )


class Rehearsal:
    """An agent, or agents side by side, in an episode that they have danced and learned once.

    Attributes:
        agent: Who acts again, without the arms.
        steps: Steps of the episode, of all agents together.
        acts: Acting and observing, as what is timed; its unit is a control step of one agent.
        learns: Learning; its unit is the same, so that it is its share of an epoch's step.
    """

    def __init__(self, config: RunConfig, runs: int | None = None) -> None:
        """Let them dance and learn."""
        seeds = config.seed if runs is None else list(range(runs))
        env = make_environments(config, seeds, ymca())
        self.agent = agent_of(config, env, seeds)
        with (
            mock.patch.object(self.agent, "act", wraps=self.agent.act) as act,
            mock.patch.object(self.agent, "observe", wraps=self.agent.observe) as observe,
        ):
            rollout(env, self.agent, 0)
        self.agent.learn()
        env.close()
        calls = zip(act.call_args_list, observe.call_args_list, strict=True)
        self._seen: list[tuple[Any, Any]] = [(seen.args[0], then.args[0]) for seen, then in calls]
        self.steps = (runs or 1) * len(self._seen)
        self.acts, self.learns = Case(self._act), Case(self._learn, self._act)

    def _act(self) -> int:
        self.agent.reset(0)
        for observation, outcome in self._seen:
            self.agent.act(observation)
            self.agent.observe(outcome)
        return self.steps

    def _learn(self) -> int:
        self.agent.learn()
        return self.steps


def _trainer(config: RunConfig, seeds: Sequence[int]) -> Trainer:
    """Return a trainer as `mpma imitate` has it, or `mpma sweep` for many seeds."""
    configs = [dataclasses.replace(config, seed=seed) for seed in seeds]
    return Trainer(configs, ymca(), keep_states=len(configs) == 1)


def _epochs(trainer: Trainer, steps: int) -> Case:
    """Return an epoch: dance, refit, measures; runs that have converged go on."""

    def run() -> int:
        trainer.run_epoch(stop=False)
        return steps

    return Case(run)


def _learn(trainer: Trainer, steps: int) -> int:
    """Train until the criteria are met; return the steps of one epoch."""
    trainer.run(_MOST_EPOCHS)
    return steps
