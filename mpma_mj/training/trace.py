"""What is recorded of an epoch, and what it amounts to."""

from __future__ import annotations

from collections.abc import Callable

import dm_env
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import Agent
from mpma_mj.agents.base import Observation
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import DivergedError

__all__ = ["epoch_metrics", "part_metrics", "record_epoch", "record_epochs"]

Array = NDArray[np.float64]

_OBSERVED = ("posture", "reference", "context", "joint_angles", "joint_velocities")


def record_epoch(env: control.Environment, agent: Agent, epoch: int) -> dict[str, Array]:
    """Dance one episode and record every signal of it.

    Args:
        env: Environment; its next episode becomes number `epoch`.
        agent: Agent; it acts and observes. Only one that learns at every step learns here.
        epoch: Number of the epoch, from 0.

    Returns:
        Signals by name. Observations of the T + 1 moments, shape (T + 1, ...), but for `posture`,
        which is that of the arms as they are, also where it is observed with noise; `action`
        (T, 8), `reward` (T,); and the agent's own signals, each (T, ...).

    Raises:
        DivergedError: The episode ended before the demonstration did.
    """
    env.task.episode = epoch
    agent.reset(epoch)
    timestep = env.reset()
    seen, done = EpisodeBuffer(), EpisodeBuffer()
    seen.append(_seen(timestep.observation, env.physics.posture()))
    while not timestep.last():
        action = agent.act(timestep.observation)
        timestep = env.step(action)
        agent.observe(timestep)
        seen.append(_seen(timestep.observation, env.physics.posture()))
        done.append({"action": action, "reward": np.asarray(timestep.reward)})
    if timestep.discount == 0.0:
        raise DivergedError(
            f"epoch {epoch + 1}: {env.task.termination_reason} at step {len(done)};"
            " try a slower --tempo or another --seed"
        )
    return seen.episode() | done.episode() | _signals(agent)


def _seen(observation: Observation, posture: Array) -> dict[str, Array]:
    """Return what is recorded of a moment: the posture of the arms as they are."""
    return {name: observation[name] for name in _OBSERVED} | {"posture": posture}


def record_epochs(
    envs: VectorImitationEnv, agent: Agent, epoch: int
) -> tuple[list[dict[str, Array]], NDArray[np.bool_]]:
    """Dance an episode with many arms side by side and record every signal of each.

    Args:
        envs: N environments; their next episode becomes number `epoch`.
        agent: As many agents side by side.
        epoch: Number of the epoch, from 0.

    Returns:
        What `record_epoch` returns, for each of the N; and whose simulation diverged, shape
        (N,), whose signals then mean nothing.
    """
    envs.episode[:] = epoch
    agent.reset(epoch)
    observation, _ = envs.reset()
    seen, done = EpisodeBuffer(), EpisodeBuffer()
    seen.append(_seen(observation, envs.posture))
    diverged = np.zeros(envs.num_envs, bool)
    for _ in range(envs.steps):
        action = agent.act(observation)
        observation, reward, terminated, _, _ = envs.step(action)
        agent.observe(dm_env.transition(reward, observation))
        seen.append(_seen(observation, envs.posture))
        done.append({"action": action, "reward": reward})
        diverged |= terminated
    together = seen.episode() | done.episode() | _signals(agent)
    traces = [
        {name: np.ascontiguousarray(signal[:, row]) for name, signal in together.items()}
        for row in range(envs.num_envs)
    ]
    return traces, diverged


def _signals(agent: Agent) -> dict[str, Array]:
    """Return an agent's signals by name, those that it has."""
    signals = agent.signals()
    named = {} if signals.modules is None else dict(vars(signals.modules))
    return named if signals.feedback is None else named | {"feedback": signals.feedback}


def epoch_metrics(
    site_positions: Callable[[Array], Array], trace: dict[str, Array]
) -> dict[str, float]:
    """Compute the measures of an epoch.

    Args:
        site_positions: Where the arms' sites are in postures; `PhysicsArms.site_positions`.
        trace: What `record_epoch` returned; measures of modules need an agent that has some.

    Returns:
        The measures by name; see `metrics` for their definitions.
    """
    posture, reference = trace["posture"][1:], trace["reference"][1:]
    measures = part_metrics(trace, np.ones(len(posture), bool)) | {
        "mpkpe_m": metrics.mpkpe(site_positions(posture), site_positions(reference)),
        "mean_reward": float(np.mean(trace["reward"])),
    }
    if "responsibility" in trace:
        responsibility, context = trace["responsibility"], trace["context"][:-1]
        measures["nmi"] = metrics.nmi(responsibility, context)
        measures["modules_used"] = metrics.modules_used(responsibility, context)
    return measures


def part_metrics(trace: dict[str, Array], part: NDArray[np.bool_]) -> dict[str, float]:
    """Compute the measures that a part of an epoch has too.

    Args:
        trace: What `record_epoch` returned; measures of modules need an agent that has some.
        part: Which steps to look at, shape (T,).

    Returns:
        The measures by name; see `metrics` for their definitions.
    """
    posture, reference = trace["posture"][1:][part], trace["reference"][1:][part]
    measures = {"p_e_percent": metrics.posture_error_percent(posture, reference)}
    if "responsibility" in trace:
        responsibility = trace["responsibility"][part]
        predicted = np.einsum("tm,tmd->td", responsibility, trace["predictions"][part])
        measures |= {
            "prediction_error_percent": metrics.posture_error_percent(predicted, posture),
            "rp_error_percent": metrics.rp_error_percent(trace["prior"][part], responsibility),
        }
    if "feedback" in trace:
        feedback, action = trace["feedback"][part], trace["action"][part]
        measures["feedback_ratio"] = metrics.feedback_ratio(feedback, action)
    return measures
