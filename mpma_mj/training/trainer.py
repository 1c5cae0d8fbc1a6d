"""Learning a movement, epoch after epoch."""

from __future__ import annotations

from dm_control.rl import control

from mpma_mj.agents import Agent
from mpma_mj.training.history import EpisodeInfo, TrainingHistory
from mpma_mj.training.trace import record_epoch

__all__ = ["Trainer"]


class Trainer(TrainingHistory):
    """Trains an agent in an environment and keeps the best epoch.

    Attributes:
        env: Environment.
        agent: Agent.
    """

    def __init__(self, env: control.Environment, agent: Agent) -> None:
        """Begin with no epoch danced."""
        super().__init__(EpisodeInfo.of(env))
        self.env = env
        self.agent = agent

    def run_epoch(self) -> bool:
        """Dance an epoch and learn from it.

        Returns:
            Whether it is the new best.
        """
        state = self.agent.state_dict()
        trace = record_epoch(self.env, self.agent, len(self.rows))
        logged = {name: float(value) for name, value in self.agent.learn().items()}
        return self.enter(trace, logged, state)
