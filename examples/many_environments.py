"""Step many environments at once, and compare the mean reward of random actions.

python examples/many_environments.py
"""

import numpy as np

import mpma_mj

envs = mpma_mj.make_vec(16, "ymca", arms="physics", seed=0)
rng = np.random.default_rng(0)
observations, infos = envs.reset()
rewards = []
for _ in range(200):
    actions = rng.uniform(-1.0, 1.0, (16, 8))
    observations, reward, terminated, truncated, infos = envs.step(actions)
    rewards.append(reward)
print(f"mean reward {np.mean(rewards):.4f}, postures {observations['posture'].shape}")
envs.close()
