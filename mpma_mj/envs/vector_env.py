"""Vector of environments that are stepped together, with Gymnasium's interface."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from mpma_mj import kinematics
from mpma_mj.envs.adaptive_starts import AdaptiveStarts
from mpma_mj.envs.arm_batch import make_batch
from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.load import prepare
from mpma_mj.envs.observation import Observer, action_space, flatten, observation_space
from mpma_mj.envs.options import check_seed, options_among, seeds_of_batch
from mpma_mj.envs.rendering import checked_mode, make_renderer
from mpma_mj.envs.step_rules import Mask, Outcome, StepRules, check_action, count_clipped, delayed
from mpma_mj.envs.tracking import Tracking
from mpma_mj.envs.vector_conventions import (
    check_going,
    checked_autoreset,
    checked_count,
    checked_reset_mask,
    masked,
    rows_where,
)
from mpma_mj.errors import StateError
from mpma_mj.motions import Motion
from mpma_mj.utils.system import processors

__all__: list[str] = ["FlatVectorImitationEnv", "VectorImitationEnv"]

Array = NDArray[np.float64]


class VectorImitationEnv(VectorEnv[Any, Any, Any]):
    """N environments that imitate the same motion, stepped by one call.

    Environment i is, number for number, the one that `mpma_mj.load` returns for seed + i. Where an
    episode has ended, another begins as Gymnasium's mode of autoreset has it:

    - NEXT_STEP: with the next `step`, whatever the action, with reward 0.
    - SAME_STEP: at once. The observation is the first of the new episode; the last observation and
      `info` of the old one are `final_obs` and `final_info` in `info`.
    - DISABLED: with `reset`, whose option `reset_mask` says where.

    Observations, rewards and `info` are those of `ImitationEnv` with an axis N in front. Not
    thread-safe.

    Attributes:
        motion: The motion.
        options: Options of the environments.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.
        last_observation: The last observations as a dictionary, also of flat environments.
        posture: Postures of the arms without observation noise, shape (N, 12).
        steps: Number of steps of an episode that starts at the beginning.
        period: Number of steps from one repetition to the next.
        context: Context at each moment of the repeated motion, shape (T, C).
        arms: One pair of arms, as model of all of them.
        episode: Number of the episode that each environment begins next, from 0, shape (N,).
    """

    _flat = False
    metadata = {"render_modes": ["rgb_array"], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        motion: Motion | str | Path = "ymca",
        *,
        seed: int = 0,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "front",
        threads: int | None = None,
        **options: Any,
    ) -> None:
        """Load the environments.

        Args:
            num_envs: Number N of environments.
            motion: The motion, or its name, or the path of a recording.
            seed: Seed of the first environment; the others' follow it.
            autoreset_mode: When an episode follows one that has ended; a mode of Gymnasium or its
                name, such as "SAME_STEP".
            render_mode: "rgb_array" for pictures, None for none.
            width: Width of each environment's picture, pixels.
            height: Height of each environment's picture, pixels.
            camera: Name of the model's camera for pictures; ours has front, side, three_quarter.
            threads: Greatest number of simulating threads; one for each processor if not given.
            **options: The fields of `EnvironmentOptions`, such as arms="kinematic".

        Raises:
            BadOptionError: An option is out of bounds, or does not exist.
            MpmaError: The motion cannot be read, or is faster than the arms.
        """
        self.options = chosen = options_among(locals())
        self.closed = True  # there is nothing to close yet
        self.num_envs = num_envs = checked_count("num_envs", num_envs)
        threads = checked_count("threads", processors() if threads is None else threads)
        self.render_mode = checked_mode(render_mode, self.metadata["render_modes"])
        self._autoreset, seed = checked_autoreset(autoreset_mode), check_seed(seed)
        self.motion, self.arms, nstep = prepare(motion, chosen)
        self.max_joint_speed = self.arms.max_joint_speed
        self.control_timestep = 1.0 / self.motion.rate
        own = {"autoreset_mode": self._autoreset, "render_fps": round(self.motion.rate, 3)}
        self.metadata = self.metadata | own
        view: dict[str, Any] = {"width": width, "height": height, "camera": camera}
        self._renderer = make_renderer(self.arms, self.render_mode, **view)
        self._demonstration = Demonstration(
            self.motion, chosen, self.max_joint_speed, self.arms.kinematics
        )
        self._randomisation = self._demonstration.randomisation
        self._starts = AdaptiveStarts.if_chosen(chosen, num_envs, self._demonstration)
        self._observer = Observer(self._demonstration, chosen)
        self.steps, self.period = self._demonstration.steps, self._demonstration.period
        self.context = self._demonstration.context
        self._rules = StepRules(
            chosen, self.steps, self._demonstration.top_speeds, self.arms.segment_lengths
        )
        self._batch = make_batch(
            self.arms, num_envs, nstep, perturbed=chosen.perturbed, threads=threads
        )
        self.single_action_space = action_space()
        self.single_observation_space = observation_space(self._observer.shapes, flat=self._flat)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.last_observation: dict[str, Array] = {}
        self.posture = np.zeros((num_envs, 12))
        self.episode = np.zeros(num_envs, int)
        self._rows, self._seeds = np.arange(num_envs), [seed + i for i in range(num_envs)]
        self._step = np.zeros(num_envs, int)
        self._tracking = Tracking(num_envs, self.steps, self.arms.keypoints)
        self._over: Mask = np.ones(num_envs, bool)
        self._every = self._over.copy()
        self._pending = np.zeros((chosen.longest_latency, num_envs, 8))
        self._drawn = self._demonstration.episode(seed, 0).repeated(num_envs)
        self.closed = False
        super().reset(seed=seed)

    @property
    def plant(self) -> NDArray[np.intp] | None:
        """Index of the plant that is on, which the next action meets, (N,); None without plants."""
        plants = self._drawn.plant
        return None if plants is None else plants[self._rows, self._step]

    @property
    def latency(self) -> NDArray[np.intp] | None:
        """Latency that the next action meets, (N,), control steps; None where it is one number."""
        latencies = self._drawn.latency
        return None if latencies is None else latencies[self._rows, self._step]

    @property
    def drawn(self) -> dict[str, Array]:
        """Options that are drawn for each episode, each (N,), by name."""
        return self._randomisation.by_name(self._drawn.drawn_options)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Start the next episode of all environments, or the first one of a seed.

        Args:
            seed: Seed of the first environment, the others' follow it; or one for each, None for
                those that keep theirs.
            options: {"reset_mask": which environments to reset, shape (N,)}, as in Gymnasium;
                the others stay as they are.

        Returns:
            Observations and info.

        Raises:
            BadOptionError: A seed is no whole number, there are not N, or there is no such option.
            ClosedEnvironmentError: `close` has been called.
        """
        self._check_open()
        mask = checked_reset_mask(options, self.num_envs) | (self.episode == 0)
        if seed is not None:
            for row, own in enumerate(seeds_of_batch(seed, self.num_envs)):
                if own is not None and mask[row]:
                    self._seeds[row], self.episode[row] = own, 0
            super().reset(seed=self._seeds[0])
        # Environments outside the mask take no step, so their episodes end no second time.
        self._over = self._over & ~mask
        self._begin_episodes(mask)
        info = self._info(self._evaluate(begins=self._every), np.zeros(self.num_envs, int))
        return self._observe(), masked(info, mask)

    def step(self, actions: ArrayLike) -> tuple[Any, Array, Mask, Mask, dict[str, Any]]:
        """Move all arms for one control step; begin an episode where one has ended.

        Args:
            actions: Joint velocities over the joints' top speeds, shape (N, 8); entries outside
                [-1, 1] are clipped.

        Returns:
            Observations; rewards, shape (N,); which episodes are terminated, shape (N,), and
            which truncated; and info.

        Raises:
            BadOptionError: The actions have another shape, or an entry is no finite number.
            ResetNeeded: `reset` has not been called, or where episodes do not follow by themselves
                an episode is over.
            ClosedEnvironmentError: `close` has been called.
        """
        self._check_open()
        self._check_under_way()
        actions = check_action(actions, (self.num_envs, 8))
        begins = self._over
        due, self._pending = delayed(self._pending, actions, self.latency)
        perturbations = self._drawn.perturbations
        forces = None if perturbations is None else perturbations[self._rows, self._step]
        if (plant := self.plant) is not None:
            self._batch.set_plants(plant)
        diverged = self._batch.step(self._rules.joint_velocities(due), forces)
        self._step += 1
        self._begin_episodes(begins)
        outcome = self._evaluate(diverged=diverged & ~begins, begins=begins)
        if self._starts is not None:
            self._starts.record(self._step, outcome.reward, ~begins)
        clipped = np.where(begins, 0, count_clipped(actions))
        self._over, entries = outcome.ended, self._info(outcome, clipped)
        if not self._over.any():
            info = masked(entries, self._every)
        elif self._autoreset is AutoresetMode.SAME_STEP:
            info = self._begin_at_once(entries)
        else:
            info = masked(entries, self._every) | masked(self._tracking_errors(), self._over)
        return self._observe(), outcome.reward, outcome.terminated, outcome.truncated, info

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return pictures of the N environments, each of shape (height, width, 3).

        Raises:
            RenderingError: OpenGL does not draw.
        """
        if self._renderer is None:
            gymnasium.logger.warn('nothing is drawn without render_mode="rgb_array"')
            return None
        pictures = []
        if (plant := self.plant) is not None:
            self._batch.set_plants(plant)
        for row in range(self.num_envs):
            self._batch.pose(row)
            pictures.append(self._renderer.picture(self._drawn.reference[row, self._step[row]]))
        return tuple(pictures)

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads and release the OpenGL context."""
        self._batch.close()
        if self._renderer is not None:
            self._renderer.close()

    def __getstate__(self) -> dict[str, Any]:
        """Refuse to be pickled or copied, as threads cannot be."""
        problem = "a vector of environments cannot be pickled or copied"
        raise StateError(problem, remedy="call make_vec again")

    def _check_open(self) -> None:
        if self.closed:
            closed = "the environments are closed; create others with make_vec()"
            raise gymnasium.error.ClosedEnvironmentError(closed)

    def _check_under_way(self) -> None:
        if not self.episode.any():
            raise gymnasium.error.ResetNeeded("no episode is under way; call reset()")
        if self._autoreset is AutoresetMode.DISABLED:
            check_going(self._over)

    def _begin_episodes(self, begins: Mask) -> None:
        """Begin an episode of these environments, shape (N,)."""
        for row in np.flatnonzero(begins).tolist():
            seed, number = self._seeds[row], self.episode[row]
            start = None if self._starts is None else self._starts.begin(row, seed, number)
            episode = self._demonstration.episode(seed, number, start)
            self._drawn.replace(row, episode)
            if (plant := self._randomisation.plant(episode.drawn_options)) is not None:
                self._batch.become_plant(row, plant)
            self._batch.set_joint_state(row, *self._demonstration.start_of(episode))
            self.episode[row] += 1
            self._step[row] = episode.start
            self._tracking.begin(row, episode.start)
            self._pending[:, row] = 0.0

    def _begin_at_once(self, entries: dict[str, Any]) -> dict[str, Any]:
        """Begin an episode where one has ended; return `info`, given the entries of the old."""
        ended, final = self._over, rows_where(self._over, self._observe())
        old = {"final_obs": final, "final_info": entries | self._tracking_errors()}
        self._over = ~self._every
        self._begin_episodes(ended)
        clipped = np.where(ended, 0, entries["clipped"])
        new = self._info(self._evaluate(begins=ended), clipped)
        return masked(new, self._every) | masked(old, ended)

    def _tracking_errors(self) -> dict[str, Array]:
        """Return the tracking errors of the episodes that are over, each shape (N,)."""
        return self._tracking.errors(self._over, self._step, self._drawn.reference)

    def _evaluate(self, *, begins: Mask, diverged: Mask | None = None) -> Outcome:
        """Compute postures and their outcome, once for reward, observation and termination."""
        now = self._rows, self._step
        self.posture = self._batch.posture()
        self._tracking.record(self._step, self.posture)
        reference = self._drawn.reference[now]
        diverged = ~self._every if diverged is None else diverged
        return self._rules.outcome(self.posture, reference, self._step, diverged, begins)

    def _observe(self) -> Any:
        """Return the observations."""
        self.last_observation = self._observer.observe(
            self._drawn,
            self._step,
            self.posture.copy(),
            self._batch.joint_angles(),
            self._batch.joint_velocities(),
            (self._rows,),
        )
        if self._flat:
            return flatten(self.last_observation, (self.num_envs,))
        return self.last_observation

    def _info(self, outcome: Outcome, clipped: NDArray[np.intp]) -> dict[str, Any]:
        """Return the entries of `info`, each of shape (N,)."""
        terms = dict(zip(kinematics.SEGMENT_NAMES, outcome.reward_terms.T, strict=True))
        info = {"reward_terms": terms, "clipped": clipped}
        info["termination_reason"] = outcome.termination_reason
        hidden = {"plant": self.plant, "latency": self.latency} | self.drawn
        return info | {name: now for name, now in hidden.items() if now is not None}


class FlatVectorImitationEnv(VectorImitationEnv):
    """The same with observations as one array, float64, shape (N, 52 + C).

    Gymnasium's vector `FlattenObservation` flattens one environment after the other, which costs
    another half of a step of 8 or 64 environments.
    """

    _flat = True
