"""PPO of Stable-Baselines3."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from evaluation import Curve, Evaluation, Policy, is_due, training_seed
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize

from mpma_mj.agents.base import Observation
from mpma_mj.envs.sb3 import make_sb3_vec
from mpma_mj.options import Arms

__all__ = ["ALONE", "ASSISTED", "PPOSettings", "learn"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PPOSettings:
    """Settings of PPO.

    Attributes:
        gamma: Discount; arms that are commanded velocities soon forget an action.
        log_std: Logarithm of the actions' first standard deviation.
        width: Neurons of each of the two layers.
        envs: Environments that dance at once.
        n_steps: Steps of each before PPO learns from them.
        batch: Steps of a minibatch.
        epochs: How often PPO goes through them.
        rate: Learning rate.
    """

    gamma: float
    log_std: float
    width: int = 64
    envs: int = 16
    n_steps: int = 128
    batch: int = 256
    epochs: int = 10
    rate: float = 3e-4


# The best in docs/results/index.md, without the feedback controller's help and with it.
ALONE = PPOSettings(gamma=0.8, log_std=-1.0, rate=1e-3)
ASSISTED = PPOSettings(gamma=0.5, log_std=-2.0)


def learn(
    seed: int,
    arms: Arms,
    steps: int,
    *,
    assisted: bool,
    settings: PPOSettings | None = None,
) -> Curve:
    """Maximise the environment's reward, and measure the policy without its randomness.

    Args:
        seed: Seed of learner and environments.
        arms: "physics" or "kinematic".
        steps: Environment steps of all members together.
        assisted: Whether the feedback controller's action is added.
        settings: Settings of PPO; `ALONE` or `ASSISTED` if not given.
    """
    settings = settings or (ASSISTED if assisted else ALONE)
    torch.set_num_threads(1)
    gain = 1.0 if assisted else 0.0
    envs = make_sb3_vec(settings.envs, arms=arms, feedback_gain=gain, error_observation=True)
    env = VecNormalize(envs, gamma=settings.gamma)
    model = PPO(
        "MlpPolicy",
        env,
        learning_rate=settings.rate,
        n_steps=settings.n_steps,
        batch_size=settings.batch,
        n_epochs=settings.epochs,
        gamma=settings.gamma,
        policy_kwargs={"net_arch": [settings.width] * 2, "log_std_init": settings.log_std},
        seed=training_seed(seed),
        device="cpu",
    )

    def act(observation: Observation) -> Array:
        flat = np.concatenate([*observation.values()], dtype=np.float32)
        normal = env.normalize_obs(flat)
        return model.predict(normal, deterministic=True)[0]

    evaluation = Evaluation(arms, assisted=assisted, error_observation=True)
    measured = 0
    while model.num_timesteps < steps:
        model.learn(settings.envs * settings.n_steps, reset_num_timesteps=False)
        if is_due(model.num_timesteps, measured, steps):
            measured = model.num_timesteps
            yield measured, evaluation.p_e(Policy(act))
    env.close()
