"""Step the environment from an agent of your own: proportional control in joint space.

python examples/own_agent.py
"""

import numpy as np

import mpma_mj
from mpma_mj.envs.wrappers import Evaluate
from mpma_mj.kinematics import angles_from_posture


class Proportional:
    """Joint velocities towards the next demonstrated posture."""

    def __init__(self, max_joint_speed: np.ndarray, timestep: float) -> None:
        """Receive top speeds, shape (8,), rad/s, and the control timestep, s."""
        self.farthest = max_joint_speed * timestep  # rad a step

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        """Return joint velocities over top speeds, shape (8,)."""
        angles = observation["joint_angles"]
        desired = angles_from_posture(observation["target"], near=angles)
        return np.clip((desired - angles) / self.farthest, -1.0, 1.0)


env = Evaluate(mpma_mj.load("ymca", arms="physics", payload=1.0, seed=0))
agent = Proportional(env.task.max_joint_speed, env.control_timestep())
timestep = env.reset()
while not timestep.last():
    timestep = env.step(agent.act(timestep.observation))
print(env.episode_metrics[-1])
