"""Agents: what acts and learns in the environments, knowing only observations."""

from mpma_mj.agents.agent_spec import AgentSpec
from mpma_mj.agents.base import Agent
from mpma_mj.agents.feedback_only import FeedbackOnly
from mpma_mj.agents.fixed import FixedAgent
from mpma_mj.agents.growing import GrowingMPMA
from mpma_mj.agents.hammer import HAMMER
from mpma_mj.agents.mosaic import MOSAIC
from mpma_mj.agents.mpma import MPMA, MPMAConfig
from mpma_mj.agents.open_loop import OpenLoop
from mpma_mj.agents.random import RandomAgent
from mpma_mj.agents.registry import AGENTS

__all__ = [
    "AGENTS",
    "HAMMER",
    "MOSAIC",
    "MPMA",
    "Agent",
    "AgentSpec",
    "FeedbackOnly",
    "FixedAgent",
    "GrowingMPMA",
    "MPMAConfig",
    "OpenLoop",
    "RandomAgent",
]
