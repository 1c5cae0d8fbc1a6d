"""Episodes of the YMCA through the interface of dm_env, for tests of wrappers."""

from __future__ import annotations

from collections.abc import Callable

import dm_env
import numpy as np

from mpma_mj import load
from mpma_mj.agents import AgentSpec, RandomAgent, RandomConfig

Act = Callable[[dict[str, np.ndarray]], np.ndarray]


SPEC = AgentSpec(4, np.full(8, 12.0), 0.05)


def ymca(arms: str = "physics", repeats: int = 1) -> dm_env.Environment:
    return load("ymca", arms=arms, repeats=repeats)


def at_random(seed: int = 0) -> Act:
    return RandomAgent(RandomConfig(), SPEC, seed=seed).act


def nothing(observation: dict[str, np.ndarray]) -> np.ndarray:
    return np.zeros(8)


def danced(env: dm_env.Environment, act: Act) -> list[dm_env.TimeStep]:
    timesteps = [env.reset()]
    while not timesteps[-1].last():
        timesteps.append(env.step(act(timesteps[-1].observation)))
    return timesteps


def assert_same(some: list[dm_env.TimeStep], others: list[dm_env.TimeStep]) -> None:
    assert len(some) == len(others)
    for one, other in zip(some, others, strict=True):
        assert one[:3] == other[:3]
        assert one.observation.keys() == other.observation.keys()
        for name, values in one.observation.items():
            np.testing.assert_array_equal(other.observation[name], values)
