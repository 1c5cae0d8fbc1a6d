"""Training of a batch of R ≥ 1 runs that differ in their seeds only."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.agents.registry import agent_class
from mpma_mj.errors import BadOptionError, DivergedError
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig
from mpma_mj.training.epoch_rows import EpochMetrics
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.history import BestEpoch, EpisodeInfo, TrainingHistory
from mpma_mj.training.rollout import TRY_INSTEAD, rollout

__all__ = ["Trainer", "check", "check_epochs", "train_agents", "train_batch"]

Array = NDArray[np.float64]
Improved = NDArray[np.bool_]
"""Whether an epoch is the new best one of each run, shape (number of all runs,)."""


class Trainer:
    """Training of a batch of runs; runs that have ended leave the batch.

    Each run gives the results that it gives when trained alone. For a single config, arrays have
    no axis of runs; a batch keeps that axis even when one run is left.

    Attributes:
        configs: Config of each run.
        motion: The motion.
        agent: Agent of the runs in training.
        histories: History of each run.
        failed: Why runs failed, by run.
        epoch: Number of epochs so far.
        going: Indices of the runs in training, shape (R,).
    """

    def __init__(
        self,
        configs: Sequence[RunConfig],
        motion: Motion,
        env_options: Mapping[str, Any] = MappingProxyType({}),
        *,
        keep_states: bool = True,
    ) -> None:
        """Create the environments and untrained agents.

        Args:
            configs: Config of each run; they differ in their seeds only.
            motion: The motion.
            env_options: Options of the environment that differ from those of the config.
            keep_states: Whether to keep the states of the agents in their best epochs.

        Raises:
            MpmaError: An option is out of bounds, or the arms cannot follow the motion.
        """
        self.configs, self.motion, self._env_options = tuple(configs), motion, env_options
        self.epoch = 0
        self.failed: dict[int, str] = {}
        self.going: NDArray[np.intp] = np.arange(len(configs))
        self._single, self._keep_states = len(configs) == 1, keep_states
        self._make_environments()
        with contextlib.ExitStack() as failed:
            failed.callback(self.close)
            self.agent = agent_of(configs[0], self._env, self._seeds)
            failed.pop_all()
        self._plants = env_options.get("plants", configs[0].env.plants) is not None
        self._learns = agent_class(configs[0].agent_name).trainable
        info = EpisodeInfo.of(self._env)
        self.histories = [TrainingHistory(info) for _ in configs]

    def run(
        self,
        epochs: int,
        *,
        stop: bool = True,
        on_epoch: Callable[[Improved], None] = lambda improved: None,
    ) -> None:
        """Run epochs until all runs have ended.

        Args:
            epochs: Largest number of epochs, those so far included.
            stop: Whether a run ends when it has converged.
            on_epoch: Called after every epoch, with what `run_epoch` returned.
        """
        while self.epoch < epochs and len(self.going):
            on_epoch(self.run_epoch(stop=stop))

    def run_epoch(self, *, stop: bool = True) -> Improved:
        """Run an epoch, learn from it, and remove runs that have ended from the batch.

        Args:
            stop: Whether a run ends when it has converged; with plants it never does, as the next
                may be new.

        Returns:
            Whether the epoch is the new best one of each run, shape (number of all runs,).
        """
        states = self._states()
        recorded = rollout(self._env, self.agent, self.epoch)
        self.epoch += 1
        # Agents whose episodes have all failed have nothing to learn from.
        learned = self.agent.learn() if len(recorded.failures) < len(self.going) else None
        if self._plants:  # the latest state is kept: an earlier one has not met all of them
            states = self._states()
        logged = {name: np.ravel(values) for name, values in (learned or {}).items()}
        improved = np.zeros(len(self.configs), bool)
        ended = np.zeros(len(self.going), bool)
        for row, run in enumerate(self.going.tolist()):
            if row in recorded.failures:
                self.failed[run] = f"epoch {self.epoch}: {recorded.failures[row]}"
                ended[row] = True
                continue
            trace = recorded.trace if self._single else recorded.trace.of_run(row)
            state = states if self._single else {name: a[row] for name, a in states.items()}
            measures = {name: float(values[row]) for name, values in logged.items()}
            history = self.histories[run]
            improved[run] = history.add(trace, measures, state, latest=self._plants)
            converged = history.converged and not self._plants
            ended[row] = not self._learns or (stop and converged)
        if ended.any():
            self._remove(ended)
        return improved

    def restore(self, rows: list[EpochMetrics], best: BestEpoch) -> None:
        """Continue a single run, whose agent has been loaded, from its epochs so far."""
        self.epoch = len(rows)
        (history,) = self.histories
        history.restore(rows, best)
        if history.converged and not self._plants:
            self._remove(np.ones(1, bool))

    def summaries(self) -> list[dict[str, Any]]:
        """Return a summary of each run; for a run that failed, the reason."""
        return [
            {"failed": self.failed[run]} if run in self.failed else history.summary()
            for run, history in enumerate(self.histories)
        ]

    def trained(self) -> TrainedAgents:
        """Return all agents in the states of their best epochs.

        Raises:
            DivergedError: A run failed; the message names its seed.
        """
        for run, reason in self.failed.items():
            seed = self.configs[run].seed
            raise DivergedError(f"seed {seed}, {reason}", remedy=TRY_INSTEAD)
        best = [history.best for history in self.histories]
        return TrainedAgents(
            configs=self.configs,
            motion=self.motion,
            state={name: np.stack([one.state[name] for one in best]) for name in best[0].state},
            epochs=np.array([int(one.row["epoch"]) for one in best]),
        )

    def close(self) -> None:
        """Close the environments."""
        self._env.close()

    def _states(self) -> dict[str, Array]:
        """Return the states of the agents, if they are kept."""
        return self.agent.state_dict() if self._keep_states else {}

    def _remove(self, ended: NDArray[np.bool_]) -> None:
        """Remove those of the R runs in training that have ended, shape (R,), from the batch."""
        remaining = np.flatnonzero(~ended)
        self.going = self.going[remaining]
        self.close()
        if len(remaining):
            self.agent.select_runs(remaining)
            self._make_environments()

    def _make_environments(self) -> None:
        """Create the environments of the runs in training."""
        seeds = [self.configs[run].seed for run in self.going]
        self._seeds = seeds[0] if self._single else seeds
        self._env = make_environments(self.configs[0], self._seeds, self.motion, self._env_options)


def check(config: RunConfig, motion: Motion) -> None:
    """Check that a run can begin, by creating it with the smallest networks.

    Raises:
        MpmaError: An option is out of bounds, or does not fit the motion.
    """
    smallest = config.replace(nodes=1) if config.agent_name in CONFIG_TYPES else config
    Trainer([smallest], motion).close()


def check_epochs(config: RunConfig, epochs: int) -> None:
    """Check that the epochs suffice for a result of the agent.

    Raises:
        BadOptionError: They do not.
    """
    least = config.agent.least_epochs
    if epochs < least:
        expected = f"at least {least}, as {config.agent_name} has no result before"
        raise BadOptionError(option="epochs", value=epochs, expected=expected)


def train_batch(
    configs: Sequence[RunConfig], motion: Motion, epochs: int, *, stop: bool = True
) -> list[dict[str, Any]]:
    """Train runs that differ in their seeds only, and return a summary of each.

    Args:
        configs: Config of each run.
        motion: The motion.
        epochs: Largest number of epochs.
        stop: Whether a run ends earlier when it has converged.

    Returns:
        Summary of each run, as `TrainingHistory.summary` returns it; for a run whose simulation
        diverged, the reason as `failed`.

    Raises:
        BadOptionError: There are fewer epochs than the agent needs.
    """
    check_epochs(configs[0], epochs)
    trainer = Trainer(configs, motion, keep_states=False)
    with one_thread(), contextlib.closing(trainer):
        trainer.run(epochs, stop=stop)
        return trainer.summaries()


def train_agents(
    configs: Sequence[RunConfig], motion: Motion, epochs: int, env_options: Mapping[str, Any]
) -> TrainedAgents:
    """Train runs that differ in their seeds only, and return their agents.

    Args:
        configs: Config of each run.
        motion: The motion.
        epochs: Largest number of epochs; each run ends earlier when it has converged.
        env_options: Options of the environment that differ from those of the config.

    Raises:
        BadOptionError: There are fewer epochs than the agent needs.
        DivergedError: A simulation diverged; the message names the seed.
    """
    check_epochs(configs[0], epochs)
    trainer = Trainer(configs, motion, env_options)
    with one_thread(), contextlib.closing(trainer):
        trainer.run(epochs)
        return trainer.trained()
