"""Where learners train, and how well they track in episodes that none trains in."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.agents import Agent
from mpma_mj.agents.base import Observation
from mpma_mj.envs.wrappers import Evaluate, FeedbackAssist, VectorFeedbackAssist
from mpma_mj.options import Arms

__all__ = ["Curve", "Evaluation", "Policy", "is_due", "make_training", "training_seed"]

Array = NDArray[np.float64]
Curve = Iterator[tuple[int, float]]
"""Environment steps of training so far and p_e after them, percent, growing steps."""

_SEED = 1_000_000_000
_EPISODES = 4
_SEEDS_OF_A_RUN = 1000
_GROWTH = 1.1


class Policy(Agent):
    """An agent that is a function from observation to action."""

    def __init__(self, act: Callable[[Observation], Array]) -> None:
        """Take the function, whose action has shape (8,)."""
        self._act = act

    def act(self, observation: Observation) -> Array:
        """Return the function's action."""
        return self._act(observation)


class Evaluation:
    """Measures policies with noise that no training episode has; its steps do not count."""

    def __init__(self, arms: Arms, *, assisted: bool = False, **options: Any) -> None:
        """Load an environment for it.

        Args:
            arms: "physics" or "kinematic".
            assisted: Whether the feedback controller's action is added.
            **options: Further options of the environment.
        """
        env = mpma_mj.load("ymca", arms=arms, seed=_SEED, **options)
        self._env = Evaluate(FeedbackAssist(env) if assisted else env)

    def p_e(self, agent: Agent) -> float:
        """Return p_e of an agent, percent, the mean of some episodes."""
        errors = []
        for episode in range(_EPISODES):
            self._env.task.episode = episode
            agent.reset(episode)
            timestep = self._env.reset()
            while not timestep.last():
                timestep = self._env.step(agent.act(timestep.observation))
            errors.append(self._env.episode_metrics.pop()["p_e_percent"])
        return float(np.mean(errors))


def make_training(num_envs: int, arms: Arms, *, assisted: bool) -> Any:
    """Return environments to train in, with the feedback controller's help or without."""
    env = mpma_mj.make_vec(num_envs, "ymca", arms=arms)
    return VectorFeedbackAssist(env) if assisted else env


def training_seed(seed: int) -> int:
    """Return the first environment seed of a run; those of two runs' members do not meet."""
    return _SEEDS_OF_A_RUN * seed


def is_due(steps: int, measured: int, last: int) -> bool:
    """Return whether to measure now: at every tenth more of steps, and at the end.

    Args:
        steps: Steps so far.
        measured: Steps when it was measured last; 0 for never.
        last: Steps at which training ends.
    """
    return steps >= min(_GROWTH * measured, last)
