"""MPMA, as `mpma imitate` trains it."""

from __future__ import annotations

from evaluation import Curve

import mpma_mj
from mpma_mj import metrics
from mpma_mj.options import Arms
from mpma_mj.training.rollout import record_epoch

__all__ = ["learn"]


def learn(seed: int, arms: Arms, steps: int, *, noise: float = 0.2) -> Curve:
    """Train MPMA and measure the training epochs themselves.

    Epoch n is danced with what was learned in n - 1 epochs, and with noise that none of them had,
    so it is a test; it counts at its end, one epoch later than the policy was there.

    Args:
        seed: Seed of agent and environment.
        arms: "physics" or "kinematic".
        steps: Environment steps.
        noise: Noise level of the reservoirs; the paper's by default.
    """
    env = mpma_mj.load("ymca", arms=arms, seed=seed)
    agent = mpma_mj.make_agent(env, mpma_mj.MPMAConfig(reservoir_noise=noise), seed=seed)
    danced = 0
    while danced < steps:
        trace = record_epoch(env, agent, danced // env.task.steps)
        danced += env.task.steps
        yield (
            danced,
            metrics.posture_error_percent(trace.posture[1:], trace.reference[1:]),
        )
        agent.learn()
