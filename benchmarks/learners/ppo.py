"""PPO of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from evaluation import Curve, Evaluation, Policy, is_due, training_seed
from gymnasium.spaces import Box
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecNormalize

from mpma_mj.agents.base import Observation
from mpma_mj.envs.sb3 import make_sb3_vec
from mpma_mj.options import Arms

__all__ = ["ALONE", "ASSISTED", "PPOSettings", "learn", "make_members"]

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


def policy_inputs(observation: Mapping[str, Array]) -> NDArray[np.float32]:
    """Return what a policy sees, shape (..., 52 + C + 12): the flat observation and the way to go.

    Posture and target are nearly the same, and only their difference tells where to go: given as
    such, normalisation makes it as large as anything else.
    """
    way = observation["target"] - observation["posture"]
    return np.concatenate([*observation.values(), way], axis=-1).astype(np.float32)


class PolicyInputs(VecEnvWrapper):
    """Environments whose observations are what a policy sees."""

    def __init__(self, venv: VecEnv) -> None:
        """Take environments of `make_sb3_vec` with dictionaries as observations."""
        parts: Any = venv.observation_space
        size = sum(part.shape[0] for part in parts.values()) + 12
        super().__init__(venv, Box(-np.inf, np.inf, (size,)))

    def reset(self) -> NDArray[np.float32]:
        """Begin an episode of every environment."""
        return policy_inputs(self.venv.reset())

    def step_wait(self) -> Any:
        """Return the outcome of a step."""
        seen, rewards, over, infos = self.venv.step_wait()
        for row in np.flatnonzero(over):
            infos[row]["terminal_observation"] = policy_inputs(infos[row]["terminal_observation"])
        return policy_inputs(seen), rewards, over, infos


def make_members(count: int, arms: Arms, *, assisted: bool) -> PolicyInputs:
    """Return environments to train in, with the feedback controller's help or without."""
    gain = 1.0 if assisted else 0.0
    return PolicyInputs(make_sb3_vec(count, arms=arms, flat=False, feedback_gain=gain))


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
    env = VecNormalize(make_members(settings.envs, arms, assisted=assisted), gamma=settings.gamma)
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
        normal = env.normalize_obs(policy_inputs(observation))
        return model.predict(normal, deterministic=True)[0]

    evaluation = Evaluation(arms, assisted=assisted)
    measured = 0
    while model.num_timesteps < steps:
        model.learn(settings.envs * settings.n_steps, reset_num_timesteps=False)
        if is_due(model.num_timesteps, measured, steps):
            measured = model.num_timesteps
            yield measured, evaluation.p_e(Policy(act))
    env.close()
