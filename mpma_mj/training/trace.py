"""What is recorded of an epoch, and what it amounts to."""

from __future__ import annotations

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import Agent
from mpma_mj.errors import DivergedError

__all__ = ["epoch_metrics", "part_metrics", "record_epoch"]

Array = NDArray[np.float64]

_OBSERVED = ("posture", "reference", "context", "joint_angles", "joint_velocities")


def record_epoch(env: control.Environment, agent: Agent, epoch: int) -> dict[str, Array]:
    """Dance one episode and record every signal of it.

    Args:
        env: Environment; its next episode becomes number `epoch`.
        agent: Agent; it acts and observes. Only one that learns at every step learns here.
        epoch: Number of the epoch, from 0.

    Returns:
        Signals by name. Observations of the T + 1 moments, shape (T + 1, ...); `action` (T, 8),
        `reward` (T,); and the agent's own signals, each (T, ...).

    Raises:
        DivergedError: The episode ended before the demonstration did.
    """
    env.task.episode = epoch
    agent.reset(epoch)
    timestep = env.reset()
    observations, actions, rewards = [timestep.observation], [], []
    while not timestep.last():
        actions.append(agent.act(timestep.observation))
        timestep = env.step(actions[-1])
        agent.observe(timestep)
        observations.append(timestep.observation)
        rewards.append(timestep.reward)
    if timestep.discount == 0.0:
        raise DivergedError(
            f"epoch {epoch + 1}: {env.task.ending} at step {len(actions)};"
            " try a slower --tempo or another --seed"
        )
    trace = {name: np.stack([o[name] for o in observations]) for name in _OBSERVED}
    trace |= {"action": np.stack(actions), "reward": np.array(rewards)}
    return trace | agent.signals()


def epoch_metrics(env: control.Environment, trace: dict[str, Array]) -> dict[str, float]:
    """Compute the measures of an epoch.

    Args:
        env: Environment in which it was danced, for the arms' own lengths.
        trace: What `record_epoch` returned, of an agent of modules.

    Returns:
        The measures by name; see `metrics` for their definitions.
    """
    posture, reference = trace["posture"][1:], trace["reference"][1:]
    responsibility, context = trace["responsibility"], trace["context"][:-1]
    sites = env.physics.site_positions
    return {
        **part_metrics(trace, np.ones(len(context), bool)),
        "nmi": metrics.nmi(responsibility, context),
        "modules_used": metrics.modules_used(responsibility, context),
        "mpkpe_m": metrics.mpkpe(sites(posture), sites(reference)),
        "mean_reward": float(np.mean(trace["reward"])),
    }


def part_metrics(trace: dict[str, Array], part: NDArray[np.bool_]) -> dict[str, float]:
    """Compute the measures that a part of an epoch has too.

    Args:
        trace: What `record_epoch` returned, of an agent of modules.
        part: Which steps to look at, shape (T,).

    Returns:
        The measures by name; see `metrics` for their definitions.
    """
    posture, reference = trace["posture"][1:][part], trace["reference"][1:][part]
    responsibility = trace["responsibility"][part]
    predicted = np.einsum("tm,tmd->td", responsibility, trace["predictions"][part])
    return {
        "p_e_percent": metrics.posture_error_percent(posture, reference),
        "prediction_error_percent": metrics.posture_error_percent(predicted, posture),
        "rp_error_percent": metrics.rp_error_percent(trace["prior"][part], responsibility),
        "feedback_ratio": metrics.feedback_ratio(trace["feedback"][part], trace["action"][part]),
    }
