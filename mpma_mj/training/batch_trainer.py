"""Many runs of one setting, trained side by side."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import DivergedError
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, architecture, environments_of, one_thread
from mpma_mj.training.history import EpisodeInfo, TrainingHistory
from mpma_mj.training.trace import record_epochs

__all__ = ["BatchTrainer", "check", "train_agents", "train_batch"]


def check(config: RunConfig, motion: Motion) -> None:
    """Refuse settings with which no run can begin, for the price of the smallest networks.

    Raises:
        MpmaError: A setting is outside what it may be, or does not fit the motion.
    """
    architecture(config)
    BatchTrainer([dataclasses.replace(config, nodes=1)], motion).close()


def train_batch(
    configs: Sequence[RunConfig], motion: Motion, epochs: int, *, stop: bool = True
) -> list[dict[str, Any]]:
    """Train runs that differ in their seeds only, side by side; each goes as it would alone.

    Args:
        configs: Settings of R runs.
        motion: The movement.
        epochs: Largest number of epochs.
        stop: Whether a run ends earlier when it has converged.

    Returns:
        A summary of each run, as `TrainingHistory.summary` returns it; of one whose simulation
        diverged `failed`, why.
    """
    with one_thread(), contextlib.closing(BatchTrainer(configs, motion)) as trainer:
        while trainer.epoch < epochs and len(trainer.going):
            trainer.run_epoch(stop=stop)
        return trainer.outcomes()


def train_agents(
    configs: Sequence[RunConfig], motion: Motion, epochs: int, env_options: Mapping[str, Any]
) -> TrainedAgents:
    """Train runs that differ in their seeds only, and return what they have learned.

    Args:
        configs: Settings of R runs.
        motion: The movement.
        epochs: Largest number of epochs; each run ends earlier when it has converged.
        env_options: Options of the environment that are other than the settings say.

    Raises:
        DivergedError: A simulation did not stay finite; names the seed.
    """
    trainer = BatchTrainer(configs, motion, env_options, keeps_states=True)
    with one_thread(), contextlib.closing(trainer):
        while trainer.epoch < epochs and len(trainer.going):
            trainer.run_epoch(stop=True)
        return trainer.trained()


class BatchTrainer:
    """Runs side by side, of which those that are over leave.

    Attributes:
        epoch: Number of epochs so far.
        going: Numbers of the runs that go on, shape (R,).
    """

    def __init__(
        self,
        configs: Sequence[RunConfig],
        motion: Motion,
        env_options: Mapping[str, Any] = MappingProxyType({}),
        *,
        keeps_states: bool = False,
    ) -> None:
        """Draw the agents and make their environments.

        Args:
            configs: Settings of the runs, which differ in their seeds only.
            motion: The movement.
            env_options: Options of the environment that are other than the settings say.
            keeps_states: Whether the agents' states of their best epochs are kept.
        """
        self.epoch = 0
        self.going: NDArray[np.intp] = np.arange(len(configs))
        self._configs, self._config, self._motion = tuple(configs), configs[0], motion
        self._env_options, self._keeps_states = env_options, keeps_states
        self._seeds = np.array([config.seed for config in configs])
        self._failed: dict[int, str] = {}
        self._make_environments()
        seeds = self._seeds.tolist()
        self._agent = agent_of(self._config, self._envs, seeds)
        self._histories = [TrainingHistory(EpisodeInfo.of(self._envs)) for _ in configs]

    def run_epoch(self, *, stop: bool) -> None:
        """Dance an epoch, learn from it, and let those leave who are done."""
        states = self._agent.state_dict() if self._keeps_states else {}
        traces, diverged = record_epochs(self._envs, self._agent, self.epoch)
        self.epoch += 1
        logged = self._agent.learn()
        learns = bool(logged)
        done = diverged.copy()
        for row, run in enumerate(self.going.tolist()):
            if diverged[row]:
                self._failed[run] = f"epoch {self.epoch}: the simulation diverged"
                continue
            history = self._histories[run]
            state = {name: array[row] for name, array in states.items()}
            own = {name: float(values[row]) for name, values in logged.items()}
            history.enter(traces[row], own, state)
            done[row] = not learns or (stop and history.converged)
        if done.any():
            self._leave(done)

    def outcomes(self) -> list[dict[str, Any]]:
        """Return a summary of each run, or why it failed."""
        return [
            {"failed": self._failed[run]} if run in self._failed else history.summary()
            for run, history in enumerate(self._histories)
        ]

    def trained(self) -> TrainedAgents:
        """Return all agents as they were in their best epochs.

        Raises:
            DivergedError: A run has none.
        """
        kept = []
        for run, history in enumerate(self._histories):
            if run in self._failed or history.best is None:
                raise DivergedError(
                    f"seed {self._seeds[run]}, {self._failed[run]}; try a slower --tempo or"
                    " another --seed"
                )
            kept.append(history.best)
        names = kept[0].state
        return TrainedAgents(
            configs=self._configs,
            motion=self._motion,
            state={name: np.stack([best.state[name] for best in kept]) for name in names},
            epochs=np.array([int(best.row["epoch"]) for best in kept]),
        )

    def close(self) -> None:
        """Give back what environments hold."""
        self._envs.close()

    def _leave(self, done: NDArray[np.bool_]) -> None:
        stay = np.flatnonzero(~done)
        self.going = self.going[stay]
        self._envs.close()
        if len(stay):
            self._agent.select_runs(stay)
            self._make_environments()

    def _make_environments(self) -> None:
        seeds = self._seeds[self.going].tolist()
        self._envs = environments_of(self._config, seeds, self._motion, self._env_options)
