"""How a trained agent dances on when the demonstration is taken away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.wrappers import FreeRunning
from mpma_mj.context import active_label
from mpma_mj.motions import Motion
from mpma_mj.training.checkpoints import load_state
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.rollout import record_epoch
from mpma_mj.training.run_folder import RunFolder

__all__ = ["REPEATS", "FreeRun", "run_freely"]

Array = NDArray[np.float64]

REPEATS = 3
"""Repetitions without the demonstration, after one with it."""


@dataclass(frozen=True, eq=False)
class FreeRun:
    """What was danced from the moment of release on, and what would have been demonstrated.

    Attributes:
        posture: Danced postures, shape (T, 12).
        reference: Demonstrated postures that were not shown, shape (T, 12).
        label: Which label's music is on, shape (T,); -1 for none.
        period: Steps of one repetition; T is at most `REPEATS` times as many.
        rate: Steps per second, Hz.
    """

    posture: Array
    reference: Array
    label: NDArray[np.int_]
    period: int
    rate: float


def run_freely(folder: RunFolder) -> tuple[FreeRun, Motion]:
    """Let the agent of a run's kept epoch dance on.

    The demonstration has no noise here, which would add to speeds and errors (choice).

    Args:
        folder: Folder of the run.

    Returns:
        What it danced, and the movement that it had learned.

    Raises:
        MpmaError: There is no run, or it is damaged, or its agent has no forward models.
        DivergedError: The simulation did not stay finite.
    """
    config, motion = folder.read_config(), folder.read_motion()
    state, epoch = folder.read_best(config)
    options = {"repeats": 1 + REPEATS, "reference_noise": 0.0}
    env = make_environments(config, config.seed, motion, options)
    period = env.task.period
    agent = FreeRunning(agent_of(config, env, config.seed), period)
    load_state(agent, state, folder.path)
    with one_thread():
        trace = record_epoch(env, agent, epoch)  # the reservoirs' noise is of the epoch after
    free = FreeRun(
        trace.posture[period:],
        trace.reference[period:],
        active_label(trace.context[period:]),
        period,
        motion.rate,
    )
    return free, motion
