"""What each worker does: agents that have learned, tried in disturbed conditions."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.registry import agent_class
from mpma_mj.errors import DivergedError
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, fine_tune, tracking_errors
from mpma_mj.experiments.backend import Work
from mpma_mj.experiments.batching import cut, seeds
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.trainer import train_agents
from mpma_mj.trials.disturbances import Level
from mpma_mj.trials.stress_conditions import Trial

__all__ = ["THIS_RUN", "Found", "Outcome", "StressJob", "jobs"]

THIS_RUN = "this run"
Outcome = Literal["danced", "diverged", "beyond the arms"]


@dataclass(frozen=True)
class Found:
    """How one agent did in one trial.

    Attributes:
        agent: Its name, or `THIS_RUN`.
        seed: Its seed.
        disturbance: Name of the disturbance.
        level: Level of the disturbance.
        outcome: Whether it danced to the end, without learning.
        p_e_percent: p_e without learning, percent; NaN where it did not.
        course: p_e after 0, 1, … epochs of learning there, percent, NaN where the simulation
            diverged; empty if there was no learning.
    """

    agent: str
    seed: int
    disturbance: str
    level: Level
    outcome: Outcome
    p_e_percent: float
    course: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class StressJob(Work):
    """Agents that are trained side by side and then tried.

    Attributes:
        agent: What the results call them.
        configs: Settings of the runs, which differ in their seeds only.
        motion: What they learn.
        epochs: Most epochs of training.
        trained: The agents, if they need no training.
        trials: The trials.
        adapts: Epochs of learning on in each of them; 0 for none.
    """

    agent: str
    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int
    trained: TrainedAgents | None
    trials: tuple[Trial, ...]
    adapts: int

    @property
    def size(self) -> int:
        """How many runs are tried, each in each trial."""
        return len(self.configs) * len(self.trials)

    def do(self) -> list[Found]:
        """Train the agents, and try them.

        Raises:
            DivergedError: A simulation did not stay finite in training; names agent and seed.
        """
        trained = self.trained or self._train()
        danced: dict[EvalCondition, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        found = []
        for trial in self.trials:
            condition = trial.condition
            if condition is not None and condition not in danced:
                danced[condition] = self._try(trained, condition)
            for row, config in enumerate(self.configs):
                name = (self.agent, config.seed, trial.disturbance, trial.level)
                if condition is None:
                    found.append(Found(*name, "beyond the arms", float("nan"), ()))
                    continue
                p_e, course = danced[condition]
                outcome: Outcome = "diverged" if np.isnan(p_e[row]) else "danced"
                found.append(Found(*name, outcome, float(p_e[row]), tuple(course[:, row].tolist())))
        return found

    def _train(self) -> TrainedAgents:
        try:
            return train_agents(self.configs, self.motion, self.epochs, {})
        except DivergedError as error:
            raise error.with_context(self.agent) from None

    def _try(
        self, trained: TrainedAgents, condition: EvalCondition
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return p_e, shape (R,), and its course as they learn, shape (epochs + 1 or 0, R)."""
        p_e = tracking_errors(evaluate(trained, condition))
        if self.adapts == 0:
            return p_e, np.empty((0, len(p_e)))
        # One epoch more, as each is danced before what is learned from it.
        return p_e, fine_tune(trained, condition, self.adapts + 1)[1]


def jobs(
    own: TrainedAgents,
    agents: Sequence[str],
    runs: int,
    epochs: int,
    trials: tuple[Trial, ...],
    adapts: int,
    workers: int,
) -> list[StressJob]:
    """Return the work to do, what takes longest first.

    Args:
        own: The run.
        agents: Agents that are trained beside it.
        runs: Runs of each, with seeds from the run's up.
        epochs: Most epochs of training.
        trials: The trials.
        adapts: Epochs of learning on, of those that can.
        workers: How many jobs are done at a time.

    Raises:
        MpmaError: An agent cannot be trained with the run's settings.
    """
    config = own.configs[0]
    rivals = [run for name in agents for run in seeds(config.replace(agent=name), runs)]
    batches = [(batch[0].agent_name, batch, None) for batch in cut(rivals, workers)]
    work = []
    for agent, configs, trained in [*batches, (THIS_RUN, own.configs, own)]:
        learns = adapts > 0 and agent_class(configs[0].agent_name).fine_tunable
        for part in _by_disturbance(trials) if learns else [trials]:
            work.append(
                StressJob(
                    agent, configs, own.motion, epochs, trained, part, adapts if learns else 0
                )
            )
    return work


def _by_disturbance(trials: tuple[Trial, ...]) -> list[tuple[Trial, ...]]:
    """Cut trials into work that is done soon enough to show; training anew costs less."""
    return [
        tuple(group) for _, group in itertools.groupby(trials, key=lambda trial: trial.disturbance)
    ]
