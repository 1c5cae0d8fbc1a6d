"""CMA-ES on the weights of a linear policy; a population dances at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cma
import numpy as np
from evaluation import Curve, Evaluation, Policy, is_due, make_training, training_seed
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents.base import Observation
from mpma_mj.options import Arms

__all__ = ["ALONE", "ASSISTED", "EvolutionSettings", "learn"]

Array = NDArray[np.float64]

_JOINTS = 8
_INPUTS = 12 + 12 + 8 + 8 + 1
_MAGNIFIED = 10.0
_WORST = 100.0  # percent: what counts where a simulation diverges


@dataclass(frozen=True)
class EvolutionSettings:
    """Settings of the strategy.

    Attributes:
        sigma: Standard deviation of the first generation's weights.
        diagonal: Whether only a diagonal covariance is learned (sep-CMA-ES).
        population: Candidates of a generation; 0 for the package's choice.
    """

    sigma: float
    diagonal: bool = False
    population: int = 0


# The best in docs/results/index.md, without the feedback controller's help and with it.
ALONE = EvolutionSettings(sigma=0.01)
ASSISTED = EvolutionSettings(sigma=0.003, diagonal=True)


def learn(
    seed: int,
    arms: Arms,
    steps: int,
    *,
    assisted: bool,
    settings: EvolutionSettings | None = None,
) -> Curve:
    """Minimise p_e of an episode, and measure the mean of the search distribution.

    Args:
        seed: Seed of strategy and environments.
        arms: "physics" or "kinematic".
        steps: Environment steps of all candidates together.
        assisted: Whether the feedback controller's action is added.
        settings: Settings of the strategy; `ALONE` or `ASSISTED` if not given.
    """
    settings = settings or (ASSISTED if assisted else ALONE)
    options: dict[str, Any] = {"seed": seed + 1, "verbose": -9, "CMA_diagonal": settings.diagonal}
    options |= {"tolfun": 0, "tolx": 0, "tolflatfitness": np.inf, "tolstagnation": np.inf}
    if settings.population:
        options["popsize"] = settings.population
    strategy = cma.CMAEvolutionStrategy(np.zeros(_JOINTS * _INPUTS), settings.sigma, options)
    env = make_training(strategy.popsize, arms, assisted=assisted)
    evaluation = Evaluation(arms, assisted=assisted)
    danced = measured = generation = 0
    while danced < steps:
        candidates = strategy.ask()
        weights = np.reshape(candidates, (-1, _JOINTS, _INPUTS))
        # The same noise for the whole generation, or the luckiest would win; then another.
        noise = training_seed(seed) * 1000 + generation
        strategy.tell(candidates, episode_errors(env, weights, noise))
        danced += strategy.popsize * env.unwrapped.steps
        generation += 1
        if is_due(danced, measured, steps):
            measured = danced
            mean = np.reshape(strategy.result.xfavorite, (_JOINTS, _INPUTS))
            yield danced, evaluation.p_e(Policy(lambda seen, mean=mean: mean @ sensed(seen)))
    env.close()


def sensed(observation: Observation) -> Array:
    """Return what the policy is linear in, shape (..., 41): what MPMA's inverse models see.

    Posture and target are nearly the same, and only their difference tells where to go: given as
    such and magnified, all inputs are about 1 and no direction of search is much steeper.
    """
    angles, target = observation["joint_angles"], observation["target"]
    way = _MAGNIFIED * (target - observation["posture"])
    one = np.ones((*angles.shape[:-1], 1))
    return np.concatenate([way, target, np.sin(angles), np.cos(angles), one], axis=-1)


def episode_errors(env: Any, weights: Array, noise: int) -> list[float]:
    """Return p_e of an episode of every candidate, percent.

    Args:
        env: Environments, one for each of N candidates.
        weights: The candidates' policies, shape (N, 8, 41).
        noise: Seed of the demonstration's noise, the same for all.
    """
    observation, _ = env.reset(seed=[noise] * len(weights))
    postures, references = [], []
    diverged = np.zeros(len(weights), bool)
    for _ in range(env.unwrapped.steps):
        actions = np.einsum("nji,ni->nj", weights, sensed(observation))
        observation, _, terminated, _, _ = env.step(actions)
        diverged |= terminated
        postures.append(observation["posture"])
        references.append(observation["reference"])
    courses = np.stack(postures, axis=1), np.stack(references, axis=1)  # (N, T, 12)
    errors = map(metrics.posture_error_percent, *courses)
    return [_WORST if fell else error for fell, error in zip(diverged, errors, strict=True)]
