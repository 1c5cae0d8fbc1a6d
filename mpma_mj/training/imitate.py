"""One run from beginning to end: train, save, and go on where a run stopped."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.registry import AGENTS, agent_class
from mpma_mj.context import active_label
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError, CheckpointError
from mpma_mj.motions import Motion
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.factory import agent_of, environment_options, one_thread
from mpma_mj.training.history import BestEpoch, EpochMetrics
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.trace import part_metrics
from mpma_mj.training.trainer import Trainer

__all__ = ["resume", "start"]

Array = NDArray[np.float64]
OnEpoch = Callable[[EpochMetrics], None]


def start(
    config: RunConfig,
    folder: RunFolder,
    epochs: int,
    *,
    overwrite: bool = False,
    on_epoch: OnEpoch = lambda row: None,
) -> dict[str, Any]:
    """Train a new agent and write its run folder.

    Args:
        config: Settings.
        folder: Where everything is written.
        epochs: Largest number of epochs; training ends earlier when it has converged.
        overwrite: Whether an earlier run in the folder may be replaced.
        on_epoch: Called with the measures of every epoch.

    Returns:
        The summary.

    Raises:
        MpmaError: Something in settings, movement or folder has to be mended.
        DivergedError: The simulation did not stay finite.
    """
    _check_epochs(epochs)
    if not agent_class(config.agent).trainable:
        raise BadOptionError(
            f"agent is {config.agent}, which does not learn; expected one of"
            f" {', '.join(name for name, own in AGENTS.items() if own.trainable)}"
        )
    motion = read_motions(config)
    with one_thread():
        trainer = _trainer(config, motion)
        folder.create(config, motion, overwrite=overwrite)
        return _train(trainer, config, folder, epochs, on_epoch)


def resume(
    folder: RunFolder, epochs: int, *, on_epoch: OnEpoch = lambda row: None
) -> dict[str, Any]:
    """Go on with a run for more epochs, as if it had never stopped.

    A run that has converged is over, and stays as it is.

    Args:
        folder: Folder of the run.
        epochs: Largest number of further epochs.
        on_epoch: Called with the measures of every further epoch.

    Returns:
        The summary.

    Raises:
        MpmaError: The folder holds no run, or a damaged one.
        DivergedError: The simulation did not stay finite.
    """
    _check_epochs(epochs)
    config = folder.read_config()
    motion = folder.read_motion()
    state, meta = folder.read_checkpoint("latest", config)
    best_state, best_meta = folder.read_checkpoint("best", config)
    trace = folder.read_trace()
    with one_thread():
        trainer = _trainer(config, motion)
        try:
            trainer.agent.load_state_dict(state)
            trainer.rows = meta["rows"]
            trainer.best = BestEpoch(best_meta["row"], best_state, trace)
        except KeyError as error:
            raise CheckpointError(
                f"{folder.path}: the checkpoint lacks {error.args[0]}; train anew"
            ) from None
        return _train(trainer, config, folder, len(trainer.rows) + epochs, on_epoch)


def _trainer(config: RunConfig, motion: Motion) -> Trainer:
    env = load(motion, **environment_options(config))
    return Trainer(env, agent_of(config, env, config.seed))


def _train(
    trainer: Trainer, config: RunConfig, folder: RunFolder, epochs: int, on_epoch: OnEpoch
) -> dict[str, Any]:
    """Train to the end, writing after every epoch what a later resume needs.

    `latest` is written last: a run that is killed in between does that epoch again.
    """
    while len(trainer.rows) < epochs and not trainer.converged:
        if trainer.run_epoch() and trainer.best is not None:
            folder.forget_epoch()
            folder.write_trace(trainer.best.trace, int(trainer.best.row["epoch"]))
            folder.write_checkpoint("best", config, trainer.best.state, {"row": trainer.best.row})
        folder.write_metrics(trainer.rows)
        state = trainer.agent.state_dict()
        folder.write_checkpoint("latest", config, state, {"rows": trainer.rows})
        on_epoch(trainer.rows[-1])
    summary = trainer.summary()
    summary["movements"] = _movement_rows(trainer, config)
    folder.write_summary(summary)
    return summary


def _movement_rows(trainer: Trainer, config: RunConfig) -> list[dict[str, Any]]:
    """Return how well each movement is danced in the kept epoch."""
    assert trainer.best is not None, "no epoch has been run"
    trace, motion = trainer.best.trace, trainer.env.task.motion
    label = active_label(trace["context"][1:])  # of the posture to which a step leads
    if len(config.motions) == 1:
        parts = {motion.name: np.ones(len(label), bool)}
    else:
        parts = {name: label == number for number, name in enumerate(motion.labels)}
    return [
        {"name": name, "steps": int(part.sum())} | part_metrics(trace, part)
        for name, part in parts.items()
    ]


def _check_epochs(epochs: int) -> None:
    if epochs < 1:
        raise BadOptionError(f"epochs is {epochs}; expected at least 1")
