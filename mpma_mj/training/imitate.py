"""One run from beginning to end: train, save, and go on where a run stopped."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from mpma_mj import metrics
from mpma_mj.agents import MPMA, MPMAConfig
from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError, CheckpointError
from mpma_mj.motions import Motion, read_motion
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.trainer import Kept, Row, Trainer

__all__ = ["make_agent", "make_env", "resume", "start", "summarize"]

Array = NDArray[np.float64]
OnEpoch = Callable[[Row], None]


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
    motion = read_motion(
        config.motion, tempo=config.tempo, segments=config.segments, max_gap=config.max_gap
    )
    _check_epochs(epochs)
    env = make_env(config, motion)
    agent = make_agent(env, config)
    folder.create(config, motion, overwrite=overwrite)
    return _train(Trainer(env, agent), env, agent, config, folder, epochs, on_epoch)


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
    env = make_env(config, folder.read_motion())
    agent = make_agent(env, config)
    trainer = Trainer(env, agent)
    state, meta = folder.read_checkpoint("latest", config)
    best_state, best_meta = folder.read_checkpoint("best", config)
    try:
        agent.load_state_dict(state)
        trainer.rows = meta["rows"]
        trainer.kept = Kept(best_meta["row"], best_state, folder.read_trace())
    except KeyError as error:
        raise CheckpointError(
            f"{folder.path}: the checkpoint lacks {error.args[0]}; train anew"
        ) from None
    return _train(trainer, env, agent, config, folder, len(trainer.rows) + epochs, on_epoch)


def make_env(config: RunConfig, motion: Motion) -> control.Environment:
    """Return the environment of a run."""
    return load(
        motion, arms=config.arms, repeats=config.repeats, noise=config.noise, seed=config.seed
    )


def make_agent(env: control.Environment, config: RunConfig) -> MPMA:
    """Return the untrained agent of a run, fitted to its environment."""
    return MPMA(
        MPMAConfig(modules=config.modules, nodes=config.nodes, rule=config.rule),
        context_size=env.observation_spec()["context"].shape[0],
        max_joint_speed=env.task.max_joint_speed,
        control_timestep=env.control_timestep(),
        seed=config.seed,
    )


def summarize(env: control.Environment, trainer: Trainer) -> dict[str, Any]:
    """Return what training came to: the measures of the kept epoch, and when it stopped."""
    assert trainer.kept is not None
    row, trace = trainer.kept.row, trainer.kept.trace
    responsibility, context = trace["responsibility"], trace["context"][:-1]
    output = responsibility[:, :, None] * trace["module_actions"]
    labels = env.task.motion.labels
    return {
        "epochs": len(trainer.rows),
        "converged": trainer.converged,
        "kept_epoch": row["epoch"],
        **{name: value for name, value in row.items() if name != "epoch"},
        "active_modules": dict(
            zip(labels, metrics.active_modules(responsibility, context), strict=True)
        ),
        "dominant_module": dict(
            zip(labels, metrics.dominant_module(responsibility, context), strict=True)
        ),
        "repeatability": {
            "responsibility": metrics.repeatability(responsibility, env.task.period),
            "module_output": metrics.repeatability(output, env.task.period),
        },
        "environment_steps": len(trainer.rows) * env.task.steps,
    }


def _train(
    trainer: Trainer,
    env: control.Environment,
    agent: MPMA,
    config: RunConfig,
    folder: RunFolder,
    epochs: int,
    on_epoch: OnEpoch,
) -> dict[str, Any]:
    """Train to the end, writing after every epoch what a later resume needs."""
    while len(trainer.rows) < epochs and not trainer.converged:
        # The matrices are small: with more threads BLAS takes twice as long.
        with threadpool_limits(1, user_api="blas"):
            improved = trainer.run_epoch()
        if improved and trainer.kept is not None:
            folder.write_trace(trainer.kept.trace, int(trainer.kept.row["epoch"]))
            folder.write_checkpoint("best", config, trainer.kept.state, {"row": trainer.kept.row})
        folder.write_checkpoint("latest", config, agent.state_dict(), {"rows": trainer.rows})
        folder.write_metrics(trainer.rows)
        on_epoch(trainer.rows[-1])
    summary = summarize(env, trainer)
    folder.write_summary(summary)
    return summary


def _check_epochs(epochs: int) -> None:
    if epochs < 1:
        raise BadOptionError(f"epochs is {epochs}; expected at least 1")
