"""Agents: what acts and learns in the environments, knowing only observations."""

from mpma_mj.agents.agent import Agent
from mpma_mj.agents.mpma import MPMA, MPMAConfig

__all__ = ["MPMA", "Agent", "MPMAConfig"]
