"""Compare agents after equal numbers of environment steps on YMCA; print p_e as Markdown.

python benchmarks/agents.py --seeds 5
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import tyro
from dm_control.rl import control
from threadpoolctl import threadpool_limits

import mpma_mj
from mpma_mj import metrics
from mpma_mj.agents import Agent, FeedbackOnly, MPMAConfig, OpenLoop, RandomAgent
from mpma_mj.training.trace import record_epoch

ARMS = ("physics", "kinematic")


def main(episodes: tuple[int, ...] = (1, 3, 7, 10), seeds: int = 5, nodes: int = 200) -> None:
    """Print the median and the range over seeds of p_e in the last of so many episodes.

    Args:
        episodes: Numbers of episodes; agents that learn do so after each.
        seeds: Number of seeds, from 0.
        nodes: Neurons of each of MPMA's reservoirs.
    """
    steps = mpma_mj.load("ymca").task.steps
    heads = [f"p_e in {n * steps - steps:,} to {n * steps:,}, %" for n in episodes]
    print("| arms | agent | " + " | ".join(heads) + " | feedback ratio at the end |")
    print("|---" * (len(heads) + 3) + "|")
    with threadpool_limits(1, user_api="blas"):
        for arms in ARMS:
            for name, make in agents(nodes).items():
                runs = [danced(arms, make, seed, max(episodes)) for seed in range(seeds)]
                errors = np.array([run[0] for run in runs])
                cells = [spread(errors[:, n - 1]) for n in episodes]
                cells.append(spread(np.array([run[1] for run in runs])))
                print(f"| {arms} | {name} | " + " | ".join(cells) + " |", flush=True)


def agents(nodes: int) -> dict[str, Callable[[control.Environment, int], Agent]]:
    """Return by name what makes each agent for an environment and a seed."""

    def limits(env: control.Environment) -> dict[str, object]:
        return {
            "max_joint_speed": env.task.max_joint_speed,
            "control_timestep": env.control_timestep(),
        }

    return {
        "random": lambda env, seed: RandomAgent(seed=seed),
        "open loop": lambda env, seed: OpenLoop(**limits(env)),
        "feedback only": lambda env, seed: FeedbackOnly(**limits(env)),
        "MPMA": lambda env, seed: mpma_mj.make_agent(env, MPMAConfig(nodes=nodes), seed=seed),
    }


def danced(
    arms: str, make: Callable[[control.Environment, int], Agent], seed: int, episodes: int
) -> tuple[list[float], float]:
    """Return p_e of every episode, percent, and the feedback ratio of the last."""
    env = mpma_mj.load("ymca", arms=arms, seed=seed)
    agent = make(env, seed)
    errors, ratio = [], 0.0
    for episode in range(episodes):
        trace = record_epoch(env, agent, episode)
        errors.append(metrics.posture_error_percent(trace["posture"][1:], trace["reference"][1:]))
        feedback = trace.get("feedback", np.zeros_like(trace["action"]))
        ratio = metrics.feedback_ratio(feedback, trace["action"])
        agent.learn()
    return errors, ratio


def spread(values: np.ndarray) -> str:
    """Return median, least and greatest as text."""
    return f"{np.median(values):.2f} ({values.min():.2f} to {values.max():.2f})"


if __name__ == "__main__":
    tyro.cli(main)
