"""Runs from beginning to end: trained, saved, and resumed where they stopped."""

from __future__ import annotations

import contextlib
import dataclasses
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.config import CONFIG_TYPES, AgentConfig
from mpma_mj.agents.registry import check_trainable
from mpma_mj.context import active_label
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError, DivergedError, OptionWarning
from mpma_mj.motions import Motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import load_state
from mpma_mj.training.config import RunConfig
from mpma_mj.training.config_json import OutsideConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.epoch_rows import EpochMetrics
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.history import BestEpoch, TrainingHistory, part_metrics
from mpma_mj.training.initial_state import begin_from, initial_state
from mpma_mj.training.rollout import TRY_INSTEAD
from mpma_mj.training.run_folder import RunFolder, open_runs
from mpma_mj.training.trainer import Improved, Trainer, check_epochs
from mpma_mj.utils.folder_lock import locked
from mpma_mj.utils.validation import is_integer
from mpma_mj.visualization.figures import write_figures

__all__ = ["Run", "imitate", "load_agent", "resume", "train"]

Array = NDArray[np.float64]
OnEpoch = Callable[[EpochMetrics], None]


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """A run that has been trained.

    Attributes:
        config: Its config.
        motion: The motion that it imitates.
        history: Metrics of its epochs, and the best epoch.
        state: State of the agent after the last epoch, with which training can be resumed.
    """

    config: RunConfig
    motion: Motion
    history: TrainingHistory
    state: Mapping[str, Array]

    def __repr__(self) -> str:
        """Return motion, agent and result in one line."""
        epochs, p_e = len(self.history.rows), self.history.best.row["p_e_percent"]
        name = self.config.agent_name
        return f"<Run of {name} on {self.motion.name}: {epochs} epochs, best p_e {p_e:.2f} %>"

    @property
    def summary(self) -> dict[str, Any]:
        """Result of the training: metrics of the best epoch, and when it stopped."""
        return self.history.summary() | {"motions": self._motion_metrics()}

    @property
    def trace(self) -> Trace:
        """Trace of the best epoch."""
        return self.history.best.trace

    @property
    def agent(self) -> Agent:
        """A new agent in the state of the best epoch, ready to act; see `load_agent`."""
        return _agent(self.config, self.motion, self.history.best.state, None)

    def save(self, folder: str | Path, *, overwrite: bool = False) -> Path:
        """Write the run folder, with figures; `mpma play` makes the video.

        Args:
            folder: The folder.
            overwrite: Whether an earlier run in the folder may be replaced.

        Returns:
            The folder.

        Raises:
            RunFolderError: The folder holds something else, or cannot be written.
        """
        run_folder = RunFolder(Path(folder))
        with locked(run_folder.path):
            run_folder.check_new(self.config, overwrite=overwrite)
            self._write_epoch(run_folder, len(self.history.rows), new=True, best=True)
            run_folder.write_summary(self.summary)
            self.write_figures(run_folder)
        return run_folder.path

    def write_figures(self, folder: RunFolder) -> None:
        """Write the figures of the best epoch to a run folder."""
        plants = int(self.summary.get("plants", 1))
        joints = read_robot(self.config.env.robot).joints
        write_figures(folder.figures, self.trace, self.motion, plants=plants, joints=joints)

    def _write_epoch(self, folder: RunFolder, epochs: int, *, new: bool, best: bool) -> None:
        """Write what a later `resume` needs; of a new run, which is the best, all it consists of.

        A run that is killed meanwhile repeats its last epoch when it is resumed.
        """
        with folder.changes(new=new, best=best) as saved:
            if new:
                saved.write_inputs(self.config, self.motion)
            if best:
                row = self.history.best.row
                saved.write_trace(self.trace, self.config, int(row["epoch"]))
                saved.write_checkpoint("best", self.config, self.history.best.state, {"row": row})
            saved.write_metrics(self.history.rows)
            saved.write_latest(self.config, self.state, self.history.rows, epochs)

    def _motion_metrics(self) -> list[dict[str, Any]]:
        """Return the metrics of each motion in the best epoch."""
        label = active_label(self.trace.context[1:])  # of the posture to which a step leads
        if len(self.config.motions) == 1:
            parts = {self.motion.name: np.ones(len(label), bool)}
        else:
            parts = {name: label == number for number, name in enumerate(self.motion.labels)}
        return [
            {"name": name, "steps": int(part.sum())} | part_metrics(self.trace, part)
            for name, part in parts.items()
        ]


def imitate(
    *motions: str | Path | Motion,
    seed: int | None = None,
    agent: AgentConfig | str | None = None,
    agent_name: str = "",
    env: EnvironmentOptions | None = None,
    reading: ReadingOptions | None = None,
    init: str | Path | None = None,
    epochs: int = 30,
    on_epoch: OnEpoch = lambda row: None,
) -> Run:
    """Train an agent to imitate a motion, and write nothing.

    Args:
        *motions: Names of built-in motions, such as "ymca", or paths of recordings, several of
            which are a repertoire; or one motion.
        seed: Seed of everything random; 0, or that of `init`, if not given.
        agent: The agent's config, or its name, or the path of its class, such as
            my_agents.py:MyAgent; "mpma", or that of `init`, if not given.
        agent_name: Path of the agent's class, where its config is given and is not built in.
        env: Options of the environment; the defaults if not given.
        reading: How recordings are read; the defaults if not given.
        init: Folder of an earlier run with whose agent the run begins, in the state of its best
            epoch (with plants: after the latest). Agent, seed and arms are those of that run, and
            what is given has to agree.
        epochs: Largest number of epochs; training ends earlier when it has converged.
        on_epoch: Called with the metrics of every epoch.

    Raises:
        MpmaError: An option is out of bounds, the motion cannot be read or followed, or the earlier
            run has another agent, other arms, or a motion with another number of labels.
        DivergedError: The simulation did not stay finite.
    """
    made = [one for one in motions if isinstance(one, Motion)]
    if not motions:
        raise BadOptionError("no motion is given; expected ymca, paths of recordings, or a Motion")
    if made and len(motions) > 1:
        raise BadOptionError(
            "several motions are given, not all by their names or paths; expected names and paths,"
            " or a single Motion"
        )
    if made and reading is not None:
        raise BadOptionError(
            "reading is given, but it is for paths, not for a Motion; leave it out"
        )
    config = RunConfig(
        motions=tuple(str(one) for one in motions) if not made else (made[0].name,),
        reading=reading or ReadingOptions(),
        env=env or EnvironmentOptions(),
        seed=0 if seed is None else seed,
    )
    if isinstance(agent, AgentConfig):
        config = dataclasses.replace(config, agent=agent, agent_name=agent_name)
    else:
        if agent_name:
            expected = "a config as agent, next to the path of its class"
            raise BadOptionError(option="agent_name", value=agent_name, expected=expected)
        if agent is not None:
            config = config.replace(agent=agent)
    if init is not None:
        given = {
            name for name, value in {"seed": seed, "agent": agent}.items() if value is not None
        }
        whole = [
            part for part in (agent, env) if isinstance(part, AgentConfig | EnvironmentOptions)
        ]
        given |= {field.name for part in whole for field in dataclasses.fields(part)}
        config = begin_from(config, init, given)
    return train(config, epochs, motion=made[0] if made else None, on_epoch=on_epoch)


def train(
    config: RunConfig,
    epochs: int = 30,
    *,
    motion: Motion | None = None,
    folder: RunFolder | None = None,
    overwrite: bool = False,
    on_epoch: OnEpoch = lambda row: None,
) -> Run:
    """Train a new agent.

    Args:
        config: Config of the run.
        epochs: Largest number of epochs; training ends earlier when it has converged.
        motion: The motion, in place of those that the config names.
        folder: The run folder, written after every epoch; nothing is written if not given.
        overwrite: Whether an earlier run in the folder may be replaced.
        on_epoch: Called with the metrics of every epoch.

    Raises:
        MpmaError: An option is out of bounds, the motion cannot be read or followed, or the folder
            cannot be written.
        DivergedError: The simulation did not stay finite.
    """
    _check(config, epochs)
    check_epochs(config, epochs)
    _warn_of_latency(config)
    motion = motion or read_motions(config)
    begins = None if config.init is None else initial_state(config, motion)
    with one_thread(), contextlib.closing(Trainer([config], motion)) as trainer:
        if config.init is not None and begins is not None:
            load_state(trainer.agent, begins, RunFolder(Path(config.init.path)).checkpoint("best"))
        if folder is not None:
            folder.check_new(config, overwrite=overwrite)
        return _train(trainer, epochs, folder, on_epoch)


def resume(
    folder: RunFolder, epochs: int | None = None, *, on_epoch: OnEpoch = lambda row: None
) -> Run:
    """Continue a run for more epochs, as if it had never stopped.

    A run that has converged is over, and stays as it is.

    Args:
        folder: The run folder.
        epochs: Largest number of further epochs; those that an interrupted run lacks if not given.
        on_epoch: Called with the metrics of every further epoch.

    Raises:
        MpmaError: The folder holds no run, or a damaged one, or something is in the way there.
        DivergedError: The simulation did not stay finite.
    """
    config = folder.read_config()
    _check(config, 1 if epochs is None else epochs)
    folder.check_places()
    motion = folder.read_motion()
    state, rows, last = folder.read_latest(config)
    best_state, row = folder.read_best(config)
    best = BestEpoch(row, best_state, folder.read_trace())
    with one_thread(), contextlib.closing(Trainer([config], motion)) as trainer:
        load_state(trainer.agent, state, folder.checkpoint("latest"))
        trainer.restore(rows, best)
        folder.write_metrics(rows)  # whatever happened to the file meanwhile
        if epochs is not None and len(trainer.going):
            last = trainer.epoch + epochs
            folder.write_latest(config, state, rows, last)
        return _train(trainer, last, folder, on_epoch)


def load_agent(folder: str | Path, *, agent: str | None = None, rule: str | None = None) -> Agent:
    """Return the trained agent of a run, in the state of its best epoch, ready to act.

    With plants that is the state after the latest epoch. The agent expects the latency of its run;
    without observing them it distinguishes plants, and latencies if it was trained with a range.

    Args:
        folder: The run folder.
        agent: Path of the agent's class, if it is from outside the package, such as
            my_agents.py:MyAgent; a run folder alone imports no code.
        rule: Path of its learning rule, likewise.

    Raises:
        RunFolderError: There is no run.
        CheckpointError: The run is damaged, of another version, or of a class that is not named.
        BadOptionError: A class is named with which the run was not trained.
    """
    (run_folder,) = open_runs([Path(folder)], agent=agent, rule=rule)
    config = run_folder.read_config()
    state, _ = run_folder.read_best(config)
    return _agent(config, run_folder.read_motion(), state, run_folder.checkpoint("best"))


def _agent(
    config: RunConfig, motion: Motion, state: Mapping[str, Array], source: Path | None
) -> Agent:
    env = make_environments(config, config.seed, motion)
    agent = load_state(agent_of(config, env, config.seed), state, source)
    agent.reset(0)
    return agent


def _train(trainer: Trainer, epochs: int, folder: RunFolder | None, on_epoch: OnEpoch) -> Run:
    """Train a single run to the end; write its folder, if there is one, after every epoch."""
    (config,), (history,) = trainer.configs, trainer.histories

    def run() -> Run:
        return Run(config, trainer.motion, history, trainer.agent.state_dict())

    def end_epoch(improved: Improved) -> None:
        for reason in trainer.failed.values():
            raise DivergedError(reason, remedy=TRY_INSTEAD)
        if folder is not None:
            last = epochs if len(trainer.going) else trainer.epoch  # less if it has converged
            new = len(history.rows) == 1
            run()._write_epoch(folder, last, new=new, best=bool(improved[0]))
        on_epoch(history.rows[-1])

    trainer.run(epochs, on_epoch=end_epoch)
    trained = run()
    if folder is not None:
        folder.write_summary(trained.summary)
    return trained


def _warn_of_latency(config: RunConfig) -> None:
    """Warn where the environment has a latency that a built-in agent cannot compensate."""
    latency, name = config.env.longest_latency, config.agent_name
    if latency and name in CONFIG_TYPES and not config.agent.compensates_latency:
        problem = f"{name} does not compensate latency, as it does not use the commands under way"
        remedy = f"use the joint models of {{agent=mpma}}, best with {{lookahead={latency + 1}}}"
        warnings.warn(OptionWarning(problem, remedy=remedy), stacklevel=3)


def _check(config: RunConfig, epochs: int) -> None:
    if not is_integer(epochs) or epochs < 1:
        raise BadOptionError(option="epochs", value=epochs, expected="a whole number of at least 1")
    if not isinstance(config.agent, OutsideConfig):
        check_trainable(config.agent_name)
