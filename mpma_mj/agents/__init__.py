"""Agents: what acts and learns in the environments, knowing only observations."""

from mpma_mj.agents.agent import Agent
from mpma_mj.agents.arena import Arena
from mpma_mj.agents.feedback_only import FeedbackOnly
from mpma_mj.agents.fixed import FixedAgent
from mpma_mj.agents.growing import GrowingMPMA
from mpma_mj.agents.hammer import HAMMER
from mpma_mj.agents.kinds import AGENTS
from mpma_mj.agents.mosaic import MOSAIC
from mpma_mj.agents.mpma import MPMA, MPMAConfig
from mpma_mj.agents.open_loop import OpenLoop
from mpma_mj.agents.random import RandomAgent

__all__ = [
    "AGENTS",
    "HAMMER",
    "MOSAIC",
    "MPMA",
    "Agent",
    "Arena",
    "FeedbackOnly",
    "FixedAgent",
    "GrowingMPMA",
    "MPMAConfig",
    "OpenLoop",
    "RandomAgent",
]
