"""Episodes of imitation: what is shown, what is observed, what is rewarded."""

from __future__ import annotations

import numpy as np
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray

from mpma_mj import kinematics
from mpma_mj.envs.actions import check_action
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.observation import Observer
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.reward import closeness, mean_reward, reward_weights, site_distance
from mpma_mj.motions import Motion
from mpma_mj.utils.clipping import clip

__all__ = ["OVER", "TOO_FAR", "TwoArmImitation"]

Array = NDArray[np.float64]

OVER = "the demonstration is over"
TOO_FAR = "an elbow or wrist is too far from the demonstrated place"


class TwoArmImitation(control.Task):
    """Follow a demonstrated movement with both arms.

    An episode is the movement danced `repeats` times in a row, with fresh noise on the
    demonstration; it starts in the demonstrated posture. What is random in episode k depends on
    the seed and k alone, so that setting `episode` is enough to continue elsewhere.

    Observation: `posture` (12), `reference` (12, demonstrated now), `target` (12, demonstrated
    at the next step), `context` (C), `joint_angles` (8, rad), `joint_velocities` (8, rad/s);
    where options ask for them `lookahead` (N, 12), the next N targets, and `phase` (2).
    Action: joint velocities over the joints' top speeds, (8,), in [-1, 1]; what is beyond is
    clipped. Reward: weighted mean of the terms that `reward_terms` returns, in [0, 1]. The end of
    the demonstration is the last step with discount 1; a simulation that diverges, or arms that
    are too far off, end an episode with 0.

    Attributes:
        motion: The movement.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        episode: Number of the episode that the next reset starts, from 0.
        seed: Seed of everything random.
        termination_reason: Why the episode has ended; empty while it goes on.
        last_action: The last action as it was given, shape (8,).
    """

    def __init__(self, motion: Motion, options: EnvironmentOptions, physics: PhysicsArms) -> None:
        """Prepare the demonstration.

        Args:
            motion: The movement, which the arms can follow.
            options: Options of the environment.
            physics: The arms.
        """
        self.motion = motion
        self.max_joint_speed = physics.max_joint_speed
        self._top_speed = np.where(options.turns, self.max_joint_speed, 0.0)
        self.episode = 0
        self.seed = options.seed
        self.termination_reason = ""
        self._demonstration = Demonstration(motion, options, self.max_joint_speed)
        self._observer = Observer(self._demonstration, options)
        self._weights = reward_weights(options.reward_weights)
        self._termination_distance = options.termination_distance
        self._latency = options.latency
        self._drawn = self._demonstration.episode(self.seed, 0)
        self._step = 0
        self.last_action = np.zeros(8)
        self._pending: list[Array] = []
        self._posture = physics.posture()

    @property
    def steps(self) -> int:
        """Number of steps of an episode that starts at the beginning."""
        return self._demonstration.steps

    @property
    def context(self) -> Array:
        """Context at each moment of the movement as it is repeated, shape (T, C)."""
        return self._demonstration.context

    @property
    def period(self) -> int:
        """Number of steps from one repetition to the next."""
        return self._demonstration.period

    @property
    def clipped(self) -> int:
        """How many entries of the last action were beyond [-1, 1]."""
        return int(np.count_nonzero(np.abs(self.last_action) > 1.0))

    def initialize_episode(self, physics: PhysicsArms) -> None:
        """Draw this episode and put the arms where it starts."""
        self._drawn = self._demonstration.episode(self.seed, self.episode)
        self.episode += 1
        self.termination_reason = ""
        self._step = self._drawn.start
        self.last_action = np.zeros(8)
        self._pending = [self.last_action] * self._latency
        physics.set_joint_state(*self._demonstration.start_of(self._drawn))
        self._posture = physics.posture()

    def before_step(self, action: Array, physics: PhysicsArms) -> None:
        """Command joint velocities.

        Raises:
            BadOptionError: The action is no array of eight finite numbers; names the entry.
        """
        self.last_action = due = check_action(action).copy()
        if self._latency:
            due, *rest = *self._pending, self.last_action
            self._pending = rest
        physics.set_control(clip(due) * self._top_speed)
        if self._drawn.perturbations is not None:
            physics.apply_perturbation(self._drawn.perturbations[self._step])

    def after_step(self, physics: PhysicsArms) -> None:
        """Go on in the demonstration."""
        self._step += 1
        self._posture = physics.posture()  # once, for reward, observation and termination

    def get_observation(self, physics: PhysicsArms) -> dict[str, Array]:
        """Return the observation, every array a copy."""
        return self._observer.observe(
            self._drawn,
            self._step,
            self._posture.copy(),
            physics.joint_angles(),
            physics.joint_velocities(),
        )

    def reward_terms(self, physics: PhysicsArms) -> dict[str, float]:
        """Return the terms of the reward by name, each in [0, 1]; 0 where arms have diverged."""
        return dict(zip(kinematics.SEGMENT_NAMES, self._terms(physics).tolist(), strict=True))

    def get_reward(self, physics: PhysicsArms) -> float:
        """Return the weighted mean of the reward's terms."""
        return float(mean_reward(self._terms(physics), self._weights))

    def get_termination(self, physics: PhysicsArms) -> float | None:
        """Return the discount where the episode ends here, else None."""
        if physics.divergence:
            self.termination_reason = physics.divergence
            return 0.0
        if self._termination_distance is not None:
            distance = site_distance(self._posture, self.reference, physics.segment_lengths)
            if distance > self._termination_distance:
                self.termination_reason = TOO_FAR
                return 0.0
        if self._step >= self.steps:
            self.termination_reason = OVER
            return 1.0
        return None

    @property
    def reference(self) -> Array:
        """Posture that is demonstrated now, shape (12,)."""
        return self._drawn.reference[self._step]

    def action_spec(self, physics: PhysicsArms) -> specs.BoundedArray:
        """Return the specification of actions."""
        return specs.BoundedArray(
            (8,), np.float64, -1.0, 1.0, name="\t".join(kinematics.JOINT_NAMES)
        )

    def observation_spec(self, physics: PhysicsArms) -> dict[str, specs.Array]:
        """Return the specifications of the observation's arrays."""
        shapes = self._observer.shapes
        return {name: specs.Array(shape, np.float64, name) for name, shape in shapes.items()}

    def _terms(self, physics: PhysicsArms) -> Array:
        if physics.divergence:
            return np.zeros(4)
        return closeness(self._posture, self.reference)
