"""What stands between an agent and the loop that runs it."""

from __future__ import annotations

from collections.abc import Mapping

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Agent, Observation
from mpma_mj.agents.paired_models import PairedModels
from mpma_mj.errors import BadOptionError

__all__ = ["AgentWrapper", "paired_models_of"]

Array = NDArray[np.float64]


class AgentWrapper:
    """An agent that is another one; subclasses change what they have to.

    Attributes:
        agent: The other one.
    """

    def __init__(self, agent: Agent) -> None:
        """Stand before an agent."""
        self.agent = agent

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self.agent.reset(episode)

    def act(self, observation: Observation) -> Array:
        """Return the agent's action."""
        return self.agent.act(observation)

    def observe(self, timestep: dm_env.TimeStep) -> None:
        """Hand on what the action led to."""
        self.agent.observe(timestep)

    def learn(self) -> dict[str, float]:
        """Let the agent learn."""
        return self.agent.learn()

    def signals(self) -> dict[str, Array]:
        """Return the agent's signals."""
        return self.agent.signals()

    def state_dict(self) -> dict[str, Array]:
        """Return what the agent has learned."""
        return self.agent.state_dict()

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from what `state_dict` returned."""
        self.agent.load_state_dict(state)


def paired_models_of(agent: Agent) -> PairedModels:
    """Return the agent with pairs of models that is behind all that stands before it.

    Raises:
        BadOptionError: The agent has no forward models.
    """
    while isinstance(agent, AgentWrapper):
        agent = agent.agent
    if not isinstance(agent, PairedModels):
        raise BadOptionError(
            f"agent is {type(agent).__name__}, which has no forward models; expected MPMA or one"
            " of its rivals"
        )
    return agent
