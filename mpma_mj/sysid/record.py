"""Logs of simulated arms, to try things out on before there is a robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.sysid.log import RobotLog
from mpma_mj.utils.clipping import clip

__all__ = ["record"]

Array = NDArray[np.float64]


def record(
    env: control.Environment, act: Callable[[Mapping[str, Array]], Array], seconds: float
) -> RobotLog:
    """Return the log of an episode: what was commanded, and what was observed of the arms.

    Args:
        env: What `mpma_mj.load` returned; it is reset. Its `latency` and `observation_noise` are
            in the log as they would be in a robot's.
        act: Returns the action, shape (8,), for an observation.
        seconds: Longest that is recorded, s; the end of the episode ends the log.
    """
    timestep = env.reset()
    period = env.control_timestep()
    rows: list[tuple[Array, Array, Array]] = []
    while not timestep.last() and len(rows) < round(seconds / period):
        observation = timestep.observation
        action = act(observation)
        command = clip(action) * env.task.max_joint_speed
        rows.append((command, observation["joint_angles"], observation["joint_velocities"]))
        timestep = env.step(action)
    command, angle, velocity = map(np.array, zip(*rows, strict=True))
    return RobotLog(np.arange(len(rows)) * period, command, angle, velocity)
