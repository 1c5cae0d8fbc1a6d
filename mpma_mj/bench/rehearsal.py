"""An episode that was danced once, for agents to act in again without the arms."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import dm_env

from mpma_mj.agents.base import Agent
from mpma_mj.bench.timing import Case
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments

__all__ = ["Rehearsal"]


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """An agent, or agents side by side, that have learned one episode, and that episode.

    Attributes:
        agent: Who acts.
        timesteps: What was observed, from the first to the last.
        runs: How many agents there are.
    """

    agent: Agent
    timesteps: tuple[dm_env.TimeStep, ...]
    runs: int

    @classmethod
    def alone(cls, config: RunConfig) -> Rehearsal:
        """Let one agent dance and learn."""
        env = make_environments(config, config.seed, ymca())
        agent = agent_of(config, env, config.seed)
        timesteps = [env.reset()]
        while not timesteps[-1].last():
            timesteps.append(env.step(agent.act(timesteps[-1].observation)))
            agent.observe(timesteps[-1])
        agent.learn()
        return cls(agent, tuple(timesteps), 1)

    @classmethod
    def side_by_side(cls, config: RunConfig, runs: int) -> Rehearsal:
        """Let as many agents as there are runs dance side by side, and learn."""
        seeds = range(runs)
        envs = make_environments(config, seeds, ymca())
        agent = agent_of(config, envs, list(seeds))
        timesteps = [dm_env.restart(envs.reset()[0])]
        for _ in range(envs.steps):
            observation, reward, *_ = envs.step(agent.act(timesteps[-1].observation))
            timesteps.append(dm_env.transition(reward, observation))
            agent.observe(timesteps[-1])
        envs.close()
        agent.learn()
        return cls(agent, tuple(timesteps), runs)

    @property
    def steps(self) -> int:
        """Steps of the episode, of all agents together."""
        return self.runs * (len(self.timesteps) - 1)

    def act(self) -> int:
        """Let the agent act and observe as then; return the steps."""
        self.agent.reset(0)
        for before, after in itertools.pairwise(self.timesteps):
            self.agent.act(before.observation)
            self.agent.observe(after)
        return self.steps

    def learn(self) -> int:
        """Let the agent learn from what it did; return the steps."""
        self.agent.learn()
        return self.steps

    @property
    def acts(self) -> Case:
        """Acting and observing, as what is timed; its unit is a control step of one agent."""
        return Case(self.act)

    @property
    def learns(self) -> Case:
        """Learning; its unit is the same, so that it is its share of an epoch's step."""
        return Case(self.learn, self.act)
