"""Episodes of imitation as a task of dm_control."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray

from mpma_mj import kinematics, metrics
from mpma_mj.envs.adaptive_starts import AdaptiveStarts
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.interventions import LONGEST_LATENCY, Intervention
from mpma_mj.envs.observation import Observer
from mpma_mj.envs.options import EnvironmentOptions, check_seed
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.step_rules import StepRules, check_action, count_clipped, delayed
from mpma_mj.errors import StateError
from mpma_mj.motions import Motion

__all__: list[str] = ["TwoArmImitation"]

Array = NDArray[np.float64]

# What changes from step to step. Arrays are replaced, not changed; the list grows.
_OF_MOMENT = (
    *("episode", "drawn", "_drawn", "_step", "_pending", "last_action"),
    *("termination_reason", "_posture", "_postures", "_outcome"),
)


class TwoArmImitation(control.Task):
    """Follow a demonstrated motion with both arms.

    An episode is `repeats` repetitions of the motion, with new noise on the demonstration; it
    starts in the demonstrated posture. All randomness of episode k depends on the seed and k
    alone, so that setting `episode` is enough to continue elsewhere; only adaptive starts depend on
    the episodes before it.

    Observation: `posture` (12), `reference` (12, demonstrated now), `target` (12, demonstrated
    at the next step), `context` (C), `joint_angles` (8, rad), `joint_velocities` (8, rad/s);
    with the options of these names also `lookahead` (N, 12), the next N targets, and `phase` (2);
    with `error_observation`, `move` (8), the joints' way to the target over their largest move.
    Action: joint velocities over the joints' top speeds, (8,), in [-1, 1]; entries outside are
    clipped. Reward: weighted mean of the terms that `reward_terms` returns, in [0, 1]. The end of
    the demonstration is the last step with discount 1; a simulation that diverges, or arms that
    are too far from the demonstration, end an episode with 0.

    Attributes:
        motion: The motion.
        options: Options of the environment.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        kinematics: Kinematics of the arms.
        steps: Number of steps of an episode that starts at the beginning.
        period: Number of steps from one repetition to the next.
        context: Context at each moment of the repeated motion, shape (T, C).
        episode: Number of the episode that the next reset starts, from 0.
        seed: Seed of everything random.
        drawn: Options that are drawn for the episode, by name.
        termination_reason: Why the episode has ended; empty while it continues.
        visualize_reward: Whether pictures show the reward, as the suite's do: the arms' own colours
            where it is 1, grey where it is 0; False at first.
        last_action: The last action as it was given, shape (8,).
        push: Forces on left and right hand in addition to those of the options, shape (2, 3), N;
            None if there were none since the environment was made.
        intervention: What is set by hand until the next intervention; None before the first.
    """

    def __init__(
        self,
        motion: Motion,
        options: EnvironmentOptions,
        physics: PhysicsArms,
        seed: int = 0,
        *,
        adjustable: bool = False,
    ) -> None:
        """Prepare the demonstration of a motion that the arms can follow.

        Args:
            motion: The motion.
            options: Options of the environment.
            physics: The arms.
            seed: Seed of everything random.
            adjustable: Whether `intervene` can be called; the arms are adjustable, too.
        """
        self.motion, self.options = motion, options
        self.max_joint_speed, self.kinematics = physics.max_joint_speed, physics.kinematics
        self.episode = 0
        self.seed = seed
        self.termination_reason = ""
        self.visualize_reward = False
        self._generator = _generator(seed)
        self._demonstration = Demonstration(
            motion, options, self.max_joint_speed, physics.kinematics
        )
        self.steps, self.period = self._demonstration.steps, self._demonstration.period
        self.context = self._demonstration.context
        self._randomisation = self._demonstration.randomisation
        self._starts = AdaptiveStarts.if_chosen(options, 1, self._demonstration)
        self._observer = Observer(self._demonstration, options)
        self._rules = StepRules(
            options, self.steps, self._demonstration.top_speeds, physics.segment_lengths
        )
        self.push: Array | None = None
        self.intervention: Intervention | None = None
        self._adjustable = adjustable
        longest = max(options.longest_latency, LONGEST_LATENCY * adjustable)
        self._pending: Array = np.zeros((longest, 8))
        self._begin(physics)
        self._evaluate(physics)

    @property
    def random(self) -> np.random.RandomState:
        """Generator for wrappers that draw, as those of dm_control's suite; the task draws none."""
        return self._generator

    @property
    def _random(self) -> np.random.RandomState:
        """The same by the name by which Shimmy reads and replaces it."""
        return self._generator

    @_random.setter
    def _random(self, generator: np.random.RandomState) -> None:
        # Shimmy replaces it to seed the environment, so that the first episode of a seed follows.
        self._generator = generator
        self.seed, self.episode = int(copy.deepcopy(generator).randint(2**31)), 0

    @property
    def reference(self) -> Array:
        """Posture that is demonstrated now, shape (12,)."""
        return self._drawn.reference[self._step]

    @property
    def step(self) -> int:
        """Step of the demonstration."""
        return int(self._step)

    @property
    def plant(self) -> int | None:
        """Index of the plant that is on, which the next action meets; None without plants."""
        if self.intervention is not None and self.intervention.plant is not None:
            return self.intervention.plant
        return None if self._drawn.plant is None else int(self._drawn.plant[self._step])

    @property
    def latency(self) -> int | None:
        """Latency that the next action meets, control steps; None where it is one number."""
        if self.intervention is not None and self.intervention.latency is not None:
            return self.intervention.latency
        return None if self._drawn.latency is None else int(self._drawn.latency[self._step])

    @property
    def clipped(self) -> int:
        """Number of entries of the last action outside [-1, 1]."""
        return int(count_clipped(self.last_action))

    def initialize_episode(self, physics: PhysicsArms) -> None:
        """Draw the next episode and set the arms to its start."""
        self._begin(physics)
        self.episode += 1
        physics.set_joint_state(*self._demonstration.start_of(self._drawn))
        self._evaluate(physics)

    def before_step(self, action: Array, physics: PhysicsArms) -> None:
        """Command joint velocities.

        Raises:
            BadOptionError: The action is no array of eight finite numbers; names the entry.
        """
        self.last_action = check_action(action).copy()
        due, self._pending = delayed(self._pending, self.last_action, self._latency)
        physics.set_control(self._rules.joint_velocities(due))
        forces = self.push
        if self._drawn.perturbations is not None:
            drawn = self._drawn.perturbations[self._step]
            forces = drawn if forces is None else drawn + forces
        if forces is not None:
            physics.apply_perturbation(forces)

    def after_step(self, physics: PhysicsArms) -> None:
        """Advance the demonstration."""
        self._step += 1
        self._switch_plant(physics)
        self._evaluate(physics, np.True_ if physics.divergence else np.False_)
        if self._starts is not None:
            step, reward = np.array([self._step]), np.array([self._outcome.reward])
            self._starts.record(step, reward, np.ones(1, bool))

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
        terms = self._outcome.reward_terms.tolist()
        return dict(zip(kinematics.SEGMENT_NAMES, terms, strict=True))

    def get_reward(self, physics: PhysicsArms) -> float:
        """Return the weighted mean of the reward's terms."""
        return float(self._outcome.reward)

    def get_termination(self, physics: PhysicsArms) -> float | None:
        """Return the discount where the episode ends here, else None."""
        if not self._outcome.ended:
            return None
        self.termination_reason = physics.divergence or self._outcome.termination_reason
        return 0.0 if self._outcome.terminated else 1.0

    def tracking_errors(self, physics: PhysicsArms) -> dict[str, float]:
        """Return `p_e_percent` and `mpkpe_m` of the steps of this episode; see `metrics`.

        The true posture of the arms counts, whatever the observation noise.
        """
        steps = slice(self._drawn.start + 1, self._step + 1)
        posture = np.array(self._postures[1:]).reshape(-1, 12)
        reference = self._drawn.reference[steps]
        return metrics.tracking_errors(posture, reference, physics.keypoints)

    def action_spec(self, physics: PhysicsArms) -> specs.BoundedArray:
        """Return the specification of actions."""
        return specs.BoundedArray(
            (8,), np.float64, -1.0, 1.0, name="\t".join(self.kinematics.joint_names)
        )

    def observation_spec(self, physics: PhysicsArms) -> dict[str, specs.Array]:
        """Return the specifications of the observation's arrays."""
        shapes = self._observer.shapes
        return {name: specs.Array(shape, np.float64, name) for name, shape in shapes.items()}

    def intervene(self, physics: PhysicsArms, intervention: Intervention) -> None:
        """Set payload, gain, plant or latency by hand, from the next action on.

        Raises:
            StateError: The environment is not adjustable.
            BadOptionError: The arms cannot become it.
        """
        if not self._adjustable:
            raise StateError("intervene() needs an environment that is made with adjustable=True")
        intervention.check(physics, len(self.options.plants or ()))
        self.intervention = intervention
        self._switch_plant(physics)

    def save_moment(self) -> tuple[dict[str, Any], int]:
        """Return the attributes of this moment, and the number of postures of the episode."""
        return {name: getattr(self, name) for name in _OF_MOMENT}, len(self._postures)

    def restore_moment(self, physics: PhysicsArms, saved: dict[str, Any], postures: int) -> None:
        """Go back to a moment of the present episode; what is set by hand stays."""
        self.__dict__.update(saved)
        del self._postures[postures:]
        self.set_plant(physics)

    @property
    def _latency(self) -> np.intp | None:
        if (latency := self.latency) is not None:
            return np.intp(latency)
        if not self._adjustable:  # as many actions are pending as the latency has steps
            return None
        return np.intp(self.options.longest_latency)

    def _begin(self, physics: PhysicsArms) -> None:
        """Draw the next episode, whose first action is yet to come."""
        seed, episode = check_seed(self.seed), check_seed(self.episode, "episode")
        start = None if self._starts is None else self._starts.begin(0, seed, episode)
        self._drawn = self._demonstration.episode(seed, episode, start)
        drawn = self._randomisation.by_name(self._drawn.drawn_options)
        self.drawn = {name: float(value) for name, value in drawn.items()}
        self._step = np.intp(self._drawn.start)
        self.termination_reason = ""
        self.last_action = np.zeros(8)
        self._pending = np.zeros_like(self._pending)
        self._postures: list[Array] = []  # from the first of the episode
        self.set_plant(physics)

    def set_plant(self, physics: PhysicsArms) -> None:
        """Let the arms be the plant of this moment of the episode, whatever they were."""
        if (plant := self._randomisation.plant(self._drawn.drawn_options)) is not None:
            physics.become_plant(plant)
        self._switch_plant(physics)

    def _switch_plant(self, physics: PhysicsArms) -> None:
        """Let the arms be the plant that is on from now."""
        if self.intervention is not None:
            plants = physics.compiled_plants.plants
            own = self._randomisation.plant(self._drawn.drawn_options) or plants[self.plant or 0]
            physics.become_plant(self.intervention.plant_values(own))
        elif self._drawn.plant is not None:
            physics.set_plant(int(self._drawn.plant[self._step]))

    def _evaluate(self, physics: PhysicsArms, diverged: np.bool_ = np.False_) -> None:
        """Compute posture and outcome, once for reward, observation and termination."""
        self._posture = physics.posture()
        self._postures.append(self._posture)
        self._outcome = self._rules.outcome(self._posture, self.reference, self._step, diverged)
        if self.visualize_reward:
            physics.set_brightness(float(self._outcome.reward))


def _generator(seed: int) -> np.random.RandomState:
    """Return the generator that dm_control's wrappers expect, from a seed of any size."""
    return np.random.RandomState(np.random.MT19937(np.random.SeedSequence(seed)))
