"""All agents by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.agent import Agent
from mpma_mj.agents.feedback_only import FeedbackOnly
from mpma_mj.agents.hammer import HAMMER
from mpma_mj.agents.mosaic import MOSAIC
from mpma_mj.agents.mpma import MPMA, MPMAConfig
from mpma_mj.agents.open_loop import OpenLoop
from mpma_mj.agents.random import RandomAgent

__all__ = ["AGENTS", "Arena"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arena:
    """What an agent has to know of where it acts.

    Attributes:
        context_size: Size of the observation's context, C.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.
    """

    context_size: int
    max_joint_speed: Array
    control_timestep: float

    @property
    def limits(self) -> dict[str, Any]:
        """What the arms can do, as arguments by name."""
        return {name: value for name, value in vars(self).items() if name != "context_size"}


def _mpma(config: MPMAConfig, arena: Arena, seed: int) -> MPMA:
    return MPMA(config, **vars(arena), seed=seed)


def _mosaic(config: MPMAConfig, arena: Arena, seed: int) -> MOSAIC:
    return MOSAIC(config, **vars(arena), seed=seed)


def _hammer(config: MPMAConfig, arena: Arena, seed: int) -> HAMMER:
    """Return as many pairs as there are labels, whatever `modules` says."""
    labelled = dataclasses.replace(config, modules=arena.context_size)
    return HAMMER(labelled, **arena.limits, seed=seed)


def _single(config: MPMAConfig, arena: Arena, seed: int) -> MPMA:
    """Return one pair, which is MPMA of one module."""
    return _mpma(dataclasses.replace(config, modules=1), arena, seed)


AGENTS: dict[str, Callable[[MPMAConfig, Arena, int], Agent]] = {
    "mpma": _mpma,
    "mosaic": _mosaic,
    "hammer": _hammer,
    "single": _single,
    "feedback_only": lambda config, arena, seed: FeedbackOnly(**arena.limits),
    "open_loop": lambda config, arena, seed: OpenLoop(**arena.limits),
    "random": lambda config, arena, seed: RandomAgent(seed=seed),
}
"""Makers of agents: what each is given are settings, of which it takes what it has, and a seed."""
