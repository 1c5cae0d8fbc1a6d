"""Agents: what acts and learns in the environments, knowing only observations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mpma_mj.agents.base import Agent, AgentSpec
    from mpma_mj.agents.baselines import FeedbackOnly, OpenLoop, RandomAgent
    from mpma_mj.agents.config import (
        AgentConfig,
        FeedbackOnlyConfig,
        GrowingConfig,
        HAMMERConfig,
        MOSAICConfig,
        MPMAConfig,
        NetworkConfig,
        OpenLoopConfig,
        RandomConfig,
        SingleConfig,
    )
    from mpma_mj.agents.growing import GrowingMPMA
    from mpma_mj.agents.hammer import HAMMER
    from mpma_mj.agents.learning_rules import Epoch, LearningRule, Readouts, learning_rule
    from mpma_mj.agents.mosaic import MOSAIC
    from mpma_mj.agents.mpma import MPMA, Single
    from mpma_mj.agents.registry import AGENTS, agent_class
    from mpma_mj.agents.signals import AgentSignals, ModuleSignals

__all__ = [
    "AGENTS",
    "HAMMER",
    "MOSAIC",
    "MPMA",
    "Agent",
    "AgentConfig",
    "AgentSignals",
    "AgentSpec",
    "Epoch",
    "FeedbackOnly",
    "FeedbackOnlyConfig",
    "GrowingConfig",
    "GrowingMPMA",
    "HAMMERConfig",
    "LearningRule",
    "MOSAICConfig",
    "MPMAConfig",
    "ModuleSignals",
    "NetworkConfig",
    "OpenLoop",
    "OpenLoopConfig",
    "RandomAgent",
    "RandomConfig",
    "Readouts",
    "Single",
    "SingleConfig",
    "agent_class",
    "learning_rule",
]

_HOMES = {
    "Agent": "base",
    "AgentSpec": "base",
    "FeedbackOnly": "baselines",
    "OpenLoop": "baselines",
    "RandomAgent": "baselines",
    "AgentConfig": "config",
    "FeedbackOnlyConfig": "config",
    "GrowingConfig": "config",
    "HAMMERConfig": "config",
    "MOSAICConfig": "config",
    "MPMAConfig": "config",
    "NetworkConfig": "config",
    "OpenLoopConfig": "config",
    "RandomConfig": "config",
    "SingleConfig": "config",
    "GrowingMPMA": "growing",
    "HAMMER": "hammer",
    "Epoch": "learning_rules",
    "LearningRule": "learning_rules",
    "Readouts": "learning_rules",
    "learning_rule": "learning_rules",
    "MOSAIC": "mosaic",
    "MPMA": "mpma",
    "Single": "mpma",
    "AGENTS": "registry",
    "agent_class": "registry",
    "AgentSignals": "signals",
    "ModuleSignals": "signals",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is used first, so that configs load without networks."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """Return the public names."""
    return __all__
