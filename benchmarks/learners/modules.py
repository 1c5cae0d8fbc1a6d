"""MPMA and learners that imitate it, as `mpma imitate` trains them."""

from __future__ import annotations

from typing import Any

from evaluation import Curve

import mpma_mj
from mpma_mj import metrics
from mpma_mj.agents.config import CONFIG_TYPES
from mpma_mj.options import Arms
from mpma_mj.training.rollout import record_epoch

__all__ = ["learn"]


def learn(seed: int, arms: Arms, steps: int, *, agent: str = "mpma", **options: Any) -> Curve:
    """Train an agent and measure the training epochs themselves.

    Epoch n is danced with what was learned in n - 1 epochs, and with noise that none of them had,
    so it is a test; it counts at its end, one epoch later than the policy was there. Epochs in
    which an agent's expert acts are not measured.

    Args:
        seed: Seed of agent and environment.
        arms: "physics" or "kinematic".
        steps: Environment steps.
        agent: Name of the agent.
        **options: Options of the agent that differ from its defaults.
    """
    env = mpma_mj.load("ymca", arms=arms, seed=seed)
    config = CONFIG_TYPES[agent](**options)
    learner = mpma_mj.make_agent(env, config, seed=seed)
    for epoch in range(1, -(-steps // env.task.steps) + 1):
        trace = record_epoch(env, learner, epoch - 1)
        if epoch >= config.least_epochs:
            p_e = metrics.posture_error_percent(trace.posture[1:], trace.reference[1:])
            yield epoch * env.task.steps, p_e
        learner.learn()
