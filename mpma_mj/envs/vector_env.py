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
from mpma_mj.envs.options import check_seed, options_from, seeds_of_batch
from mpma_mj.envs.step_rules import Mask, Outcome, StepRules, check_action, count_clipped, delayed
from mpma_mj.errors import BadOptionError, StateError
from mpma_mj.motions import Motion
from mpma_mj.utils.system import processors
from mpma_mj.utils.validation import is_integer

__all__: list[str] = ["FlatVectorImitationEnv", "VectorImitationEnv"]

Array = NDArray[np.float64]


class VectorImitationEnv(VectorEnv[Any, Any, Any]):
    """N environments that imitate the same motion, stepped by one call.

    Environment i is, number for number, the one that `mpma_mj.load` returns for seed + i. Where an
    episode has ended, the next `step` begins another, whatever the action: reward 0, not
    terminated, the first observation (Gymnasium's autoreset at the next step).

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
    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        motion: Motion | str | Path = "ymca",
        *,
        seed: int = 0,
        render_mode: None = None,
        threads: int | None = None,
        **options: Any,
    ) -> None:
        """Load the environments.

        Args:
            num_envs: Number N of environments.
            motion: The motion, or its name, or the path of a recording.
            seed: Seed of the first environment; the others' follow it.
            render_mode: None; a vector of environments draws no pictures.
            threads: Greatest number of simulating threads; one for each processor if not given.
            **options: The fields of `EnvironmentOptions`, such as arms="kinematic".

        Raises:
            BadOptionError: An option is out of bounds, or does not exist.
            MpmaError: The motion cannot be read, or is faster than the arms.
        """
        self.closed = True  # there is nothing to close yet
        threads = processors() if threads is None else threads
        for name, count in (("num_envs", num_envs), ("threads", threads)):
            if not (is_integer(count) and int(count) >= 1):
                raise BadOptionError(option=name, value=count, expected="a whole number from 1 up")
        if render_mode is not None:
            expected = "None, as a vector of environments draws no pictures"
            raise BadOptionError(option="render_mode", value=render_mode, expected=expected)
        chosen, seed = options_from(options), check_seed(seed)
        self.options = chosen
        self.motion, self.arms, nstep = prepare(motion, chosen)
        self.num_envs = num_envs = int(num_envs)
        self.max_joint_speed = self.arms.max_joint_speed
        self.control_timestep = 1.0 / self.motion.rate
        self._demonstration = Demonstration(self.motion, chosen, self.max_joint_speed)
        self._randomisation = self._demonstration.randomisation
        self._starts = AdaptiveStarts.if_chosen(chosen, num_envs, self._demonstration)
        self._observer = Observer(self._demonstration, chosen)
        self.steps, self.period = self._demonstration.steps, self._demonstration.period
        self.context = self._demonstration.context
        self._rules = StepRules(chosen, self.steps, self.max_joint_speed, self.arms.segment_lengths)
        self._batch = make_batch(
            self.arms, num_envs, nstep, perturbed=chosen.perturbed, threads=int(threads)
        )
        self.single_action_space = action_space()
        self.single_observation_space = observation_space(self._observer.shapes, flat=self._flat)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.last_observation: dict[str, Array] = {}
        self.posture = np.zeros((num_envs, 12))
        self.episode = np.zeros(num_envs, int)
        self._rows = np.arange(num_envs)
        self._seeds = [seed + row for row in range(num_envs)]
        self._step = np.zeros(num_envs, int)
        self._over: Mask = np.ones(num_envs, bool)
        self._termination_reason = np.full(num_envs, "", object)
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
        """Numbers that are drawn for each episode, (N,), by names of options that are ranges."""
        return self._randomisation.by_name(self._drawn.numbers)

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
            BadOptionError: A seed is negative or no integer, or there are not N of them; or
                there is no such option.
            ClosedEnvironmentError: `close` has been called.
        """
        self._check_open()
        mask = self._mask(options) | (self.episode == 0)
        if seed is not None:
            for row, own in enumerate(seeds_of_batch(seed, self.num_envs)):
                if own is not None and mask[row]:
                    self._seeds[row], self.episode[row] = own, 0
            super().reset(seed=self._seeds[0])
        # Environments outside the mask take no step, so their episodes end no second time.
        over, reason = self._over & ~mask, np.where(mask, "", self._termination_reason)
        self._begin_episodes(mask)
        every, none = np.ones(self.num_envs, bool), np.zeros(self.num_envs, bool)
        outcome = self._evaluate(diverged=none, begins=every)
        self._over, self._termination_reason = over, reason
        return self._observe(), self._info(outcome, np.zeros(self.num_envs, int))

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
            ResetNeeded: `reset` has not been called.
            ClosedEnvironmentError: `close` has been called.
        """
        self._check_open()
        if not self.episode.any():
            raise gymnasium.error.ResetNeeded("no episode is under way; call reset()")
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
        self._over, self._termination_reason = outcome.ended, outcome.termination_reason
        info = self._info(outcome, np.where(begins, 0, count_clipped(actions)))
        return self._observe(), outcome.reward, outcome.terminated, outcome.truncated, info

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self._batch.close()

    def __getstate__(self) -> dict[str, Any]:
        """Refuse to be pickled or copied, as threads cannot be."""
        raise StateError(
            "a vector of environments cannot be pickled or copied; call make_vec again"
        )

    def _check_open(self) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError(
                "the environments are closed; create others with make_vec()"
            )

    def _mask(self, options: dict[str, Any] | None) -> Mask:
        """Return which environments are to be reset, shape (N,)."""
        if not options:
            return np.ones(self.num_envs, bool)
        try:
            mask = np.array(options.get("reset_mask")) if isinstance(options, dict) else None
        except ValueError:  # rows of different lengths
            mask = None
        expected = (np.dtype(bool), (self.num_envs,))
        if mask is None or (mask.dtype, mask.shape) != expected or len(options) > 1:
            raise BadOptionError(
                option="options",
                value=options,
                expected=f"None, or a reset_mask of {self.num_envs} booleans",
            )
        return mask

    def _begin_episodes(self, begins: Mask) -> None:
        """Begin an episode of these environments, shape (N,)."""
        for row in np.flatnonzero(begins).tolist():
            seed, number = self._seeds[row], self.episode[row]
            start = None if self._starts is None else self._starts.begin(row, seed, number)
            episode = self._demonstration.episode(seed, number, start)
            self._drawn.replace(row, episode)
            if (plant := self._randomisation.plant(episode.numbers)) is not None:
                self._batch.become_plant(row, plant)
            self._batch.set_joint_state(row, *self._demonstration.start_of(episode))
            self.episode[row] += 1
            self._step[row] = episode.start
            self._pending[:, row] = 0.0

    def _evaluate(self, *, diverged: Mask, begins: Mask) -> Outcome:
        """Compute postures and their outcome, once for reward, observation and termination."""
        self.posture = self._batch.posture()
        reference = self._drawn.reference[self._rows, self._step]
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
        """Return `info` in Gymnasium's layout: a mask of the environments that have each entry."""
        terms = dict(zip(kinematics.SEGMENT_NAMES, outcome.reward_terms.T, strict=True))
        info = {"reward_terms": self._masked(terms), "clipped": clipped}
        info["termination_reason"] = self._termination_reason.copy()
        hidden = {"plant": self.plant, "latency": self.latency} | self.drawn
        return self._masked(info | {name: now for name, now in hidden.items() if now is not None})

    def _masked(self, info: dict[str, Any]) -> dict[str, Any]:
        return info | {f"_{name}": np.ones(self.num_envs, bool) for name in info}


class FlatVectorImitationEnv(VectorImitationEnv):
    """The same with observations as one array, float64, shape (N, 52 + C).

    Gymnasium's vector `FlattenObservation` flattens one environment after the other, which costs
    another half of a step of 8 or 64 environments.
    """

    _flat = True
