"""Agents that learn nothing more."""

from __future__ import annotations

import dm_env

from mpma_mj.agents.wrapper import AgentWrapper

__all__ = ["Frozen"]


class Frozen(AgentWrapper):
    """An agent that acts as it has learned to, whatever comes of it."""

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Keep from the agent what it could learn from."""

    def learn(self) -> dict[str, float]:
        """Learn nothing."""
        return {}
