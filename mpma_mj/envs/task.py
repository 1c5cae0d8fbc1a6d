"""Episodes of imitation: what is shown, what is observed, what is rewarded."""

from __future__ import annotations

import numpy as np
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray

from mpma_mj import arm
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.motions import Motion
from mpma_mj.motions.reach import check_reach
from mpma_mj.motions.repeat import repeat
from mpma_mj.randomness import stream

__all__ = ["TwoArmImitation"]

Array = NDArray[np.float64]

# Distance between demonstrated and actual unit vector at which a reward term falls to 0.1;
# 0.5 is an angle of 29 degrees. (choice)
_REWARD_MARGIN = 0.5
_REWARD_DECAY = np.full(3, np.log(0.1) / _REWARD_MARGIN**2)  # sums over x, y, z on the way


class TwoArmImitation(control.Task):
    """Follow a demonstrated movement with both arms.

    An episode is the movement danced `repeats` times in a row, with fresh noise on the
    demonstration; it starts in the demonstrated posture. The noise of episode k depends on the
    seed and k alone, so that setting `episode` is enough to continue elsewhere.

    Observation: `posture` (12), `reference` (12, demonstrated now), `target` (12, demonstrated
    at the next step), `context` (C), `joint_angles` (8, rad), `joint_velocities` (8, rad/s).
    Action: joint velocities over the joints' top speeds, (8,), in [-1, 1]; what is beyond is
    clipped. Reward: mean of the terms that `reward_terms` returns, in [0, 1]. The end of the
    demonstration is the last step with discount 1; a simulation that diverges ends with 0.

    Attributes:
        motion: The movement.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        episode: Number of the episode that the next reset starts, from 0.
        seed: Seed of the noise.
        period: Number of steps from one repetition to the next.
    """

    def __init__(
        self,
        motion: Motion,
        *,
        max_joint_speed: Array,
        max_elbow: float,
        repeats: int = 3,
        noise: float = 0.01,
        seed: int = 0,
    ) -> None:
        """Prepare the demonstration.

        Args:
            motion: The movement.
            max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
            max_elbow: Farthest that an elbow bends, rad.
            repeats: How often the movement is danced in an episode.
            noise: Standard deviation of the noise on each coordinate of the demonstrated unit
                vectors, which are then made unit vectors again; the paper's 1 % is 0.01.
            seed: Seed of the noise.

        Raises:
            MotionReachError: The arms cannot follow the movement.
        """
        check_reach(motion, max_joint_speed, max_elbow)
        self.motion = motion
        self.max_joint_speed = max_joint_speed
        self.episode = 0
        self._noise = noise
        self.seed = seed
        self._clean, self._context = repeat(motion, repeats, max_joint_speed)
        between = len(self._clean) - repeats * len(motion)  # postures of all return moves
        self.period = len(motion) + between // max(repeats - 1, 1)
        self._start_angles = arm.angles_from_posture(self._clean[0], near=np.zeros(8))
        self._demonstration = self._clean
        self._step = 0

    @property
    def steps(self) -> int:
        """Number of steps of an episode."""
        return len(self._clean) - 1

    def initialize_episode(self, physics: PhysicsArms) -> None:
        """Put the arms into the first posture and draw this episode's demonstration."""
        self._demonstration = self._noisy(stream(self.seed, "demonstration", self.episode))
        self.episode += 1
        self._step = 0
        physics.data.qpos[:] = self._start_angles

    def before_step(self, action: Array, physics: PhysicsArms) -> None:
        """Command joint velocities."""
        # Twice as fast as np.clip.
        physics.set_control(np.minimum(np.maximum(action, -1.0), 1.0) * self.max_joint_speed)

    def after_step(self, physics: PhysicsArms) -> None:
        """Go on in the demonstration."""
        self._step += 1

    def get_observation(self, physics: PhysicsArms) -> dict[str, Array]:
        """Return the observation, every array a copy."""
        now, after = self._step, min(self._step + 1, self.steps)
        return {
            "posture": physics.posture(),
            "reference": self._demonstration[now].copy(),
            "target": self._demonstration[after].copy(),
            "context": self._context[now].copy(),
            "joint_angles": physics.joint_angles(),
            "joint_velocities": physics.joint_velocities(),
        }

    def reward_terms(self, physics: PhysicsArms) -> dict[str, float]:
        """Return the terms of the reward by name, each in [0, 1]."""
        return dict(zip(arm.SEGMENT_NAMES, self._closeness(physics).tolist(), strict=True))

    def get_reward(self, physics: PhysicsArms) -> float:
        """Return the mean of the reward's terms, 0 where the simulation has diverged."""
        if physics.diverged:
            return 0.0
        return float(np.add.reduce(self._closeness(physics))) / 4.0

    def _closeness(self, physics: PhysicsArms) -> Array:
        """Return 0.1^(d²/m²) for each segment, shape (4,).

        d is the distance of the unit vectors, m the margin: dm_control's Gaussian tolerance.
        """
        error = physics.posture() - self._demonstration[self._step]
        return np.exp(np.dot((error * error).reshape(4, 3), _REWARD_DECAY))

    def get_termination(self, physics: PhysicsArms) -> float | None:
        """Return the discount where the episode ends here, else None."""
        if physics.diverged:
            return 0.0
        return 1.0 if self._step >= self.steps else None

    def action_spec(self, physics: PhysicsArms) -> specs.BoundedArray:
        """Return the specification of actions."""
        return specs.BoundedArray((8,), np.float64, -1.0, 1.0, name="\t".join(arm.JOINT_NAMES))

    def observation_spec(self, physics: PhysicsArms) -> dict[str, specs.Array]:
        """Return the specifications of the observation's arrays."""
        labels = len(self.motion.labels)
        sizes = {"posture": 12, "reference": 12, "target": 12, "context": labels}
        sizes |= {"joint_angles": 8, "joint_velocities": 8}
        return {name: specs.Array((size,), np.float64, name) for name, size in sizes.items()}

    def _noisy(self, rng: np.random.Generator) -> Array:
        vectors = self._clean.reshape(-1, 4, 3)
        vectors = vectors + self._noise * rng.standard_normal(vectors.shape)
        return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).reshape(-1, 12)
