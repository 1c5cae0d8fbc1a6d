"""Many environments at once, stepped together, behind Gymnasium's interface for vectors."""

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
from mpma_mj.envs.actions import check_action
from mpma_mj.envs.arm_batch import make_batch
from mpma_mj.envs.demonstration import Demonstration, Episode
from mpma_mj.envs.load import prepare
from mpma_mj.envs.observation import Observer
from mpma_mj.envs.options import options_from, seeds_of_batch
from mpma_mj.envs.reward import closeness, mean_reward, reward_weights, site_distance
from mpma_mj.envs.spaces import action_space, flatten, observation_space
from mpma_mj.envs.task import OVER, TOO_FAR
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import Motion
from mpma_mj.utils.clipping import clip
from mpma_mj.utils.system import processors
from mpma_mj.utils.validation import is_integer

__all__ = ["FlatVectorImitationEnv", "VectorImitationEnv", "make_vec"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_DIVERGED = "the simulation diverged"


class VectorImitationEnv(VectorEnv[Any, Any, Any]):
    """N environments that imitate the same movement, one call for all.

    Member i is, number for number, the environment that `mpma_mj.load` makes with seed + i. Where
    an episode has ended, the next `step` begins another, whatever the action: reward 0, not
    terminated, the first observation (Gymnasium's autoreset at the next step).

    Observations, rewards and `info` are those of `ImitationEnv` with an axis N in front. To be
    used by one Python thread at a time.

    Attributes:
        motion: The movement.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.
        seen: The last observations as a dictionary, also where the environments are flat.
        posture: Postures of the arms as they are, however they are observed, shape (N, 12).
        steps: Number of steps of an episode that starts at the beginning.
        period: Number of steps from one repetition to the next.
        context: Context at each moment of the movement as it is repeated, shape (T, C).
        arms: A pair of arms like all of them.
        episode: Number of the episode that each member begins next, from 0, shape (N,).
    """

    _flat = False
    metadata = {  # noqa: RUF012
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        *,
        render_mode: None = None,
        threads: int | None = None,
        **options: Any,
    ) -> None:
        """Load the environments.

        Args:
            num_envs: Number N of environments.
            render_mode: None; for pictures take a single environment.
            threads: Most threads that simulate; one for each processor if not given.
            **options: The fields of `EnvironmentOptions`, such as arms="kinematic".

        Raises:
            BadOptionError: An option is outside what it may be, or there is none of that name.
            MpmaError: The movement cannot be read, or is faster than the arms.
        """
        self.closed = True  # there is nothing to close yet
        if not (is_integer(num_envs) and int(num_envs) >= 1):
            raise BadOptionError(f"num_envs is {num_envs!r}; expected a whole number from 1 up")
        if threads is not None and not (is_integer(threads) and int(threads) >= 1):
            raise BadOptionError(f"threads is {threads!r}; expected a whole number from 1 up")
        if render_mode is not None:
            raise BadOptionError("many environments draw nothing; leave render_mode out")
        chosen = options_from(**options)
        self.motion, self.arms, nstep = prepare(chosen)
        self.num_envs = num_envs = int(num_envs)
        self.max_joint_speed = self.arms.max_joint_speed
        self.control_timestep = 1.0 / self.motion.rate
        self._options = chosen
        self._top_speed = np.where(chosen.turns, self.max_joint_speed, 0.0)
        self._demonstration = Demonstration(self.motion, chosen, self.max_joint_speed)
        self._observer = Observer(self._demonstration, chosen)
        self._weights = reward_weights(chosen.reward_weights)
        self._batch = make_batch(
            self.arms,
            num_envs,
            nstep,
            perturbed=chosen.perturbed,
            threads=int(threads or processors()),
        )
        self.steps, self.period = self._demonstration.steps, self._demonstration.period
        self.single_action_space = action_space()
        self.single_observation_space = observation_space(self._observer.shapes, flat=self._flat)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.context = self._demonstration.context
        self.seen: dict[str, Array] = {}
        self.posture = np.zeros((num_envs, 12))
        self._rows = np.arange(num_envs)
        self._seeds = [chosen.seed + row for row in range(num_envs)]
        self.episode = np.zeros(num_envs, int)
        self._step = np.zeros(num_envs, int)
        self._over = np.ones(num_envs, bool)
        self._termination_reason = np.full(num_envs, "", object)
        self._pending = np.zeros((chosen.latency, num_envs, 8))
        self._drawn = _space_for(self._demonstration.episode(chosen.seed, 0), num_envs)
        self.closed = False
        super().reset(seed=chosen.seed)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Start the next episode of all members, or the first one of a seed.

        Args:
            seed: Seed of the first member, the others' follow it; or one for each, None for
                those that go on with theirs.
            options: {"reset_mask": which members are meant, shape (N,)}, as Gymnasium has it;
                the others stay where they are.

        Returns:
            Observations and info.

        Raises:
            BadOptionError: A seed is no whole number from 0 up, or there are not N of them; or
                there is no such option.
            ClosedEnvironmentError: `close` has been called.
        """
        self._check_open()
        meant = self._mask(options) | (self.episode == 0)
        if seed is not None:
            for row, own in enumerate(seeds_of_batch(seed, self.num_envs)):
                if own is not None and meant[row]:
                    self._seeds[row], self.episode[row] = own, 0
            super().reset(seed=self._seeds[0])
        over_before, ending_before = self._over & ~meant, self._termination_reason
        self._over = meant
        self._begin_episodes()
        nothing = np.zeros(self.num_envs, bool)
        observation, _, _, _, info = self._outcome(~nothing, nothing, np.zeros((self.num_envs, 8)))
        self._over = over_before
        info["termination_reason"] = self._termination_reason = np.where(meant, "", ending_before)
        return observation, info

    def step(self, actions: ArrayLike) -> tuple[Any, Array, Mask, Mask, dict[str, Any]]:
        """Move all arms for one control step; begin an episode where one has ended.

        Args:
            actions: Joint velocities over the joints' top speeds, shape (N, 8); what is beyond
                [-1, 1] is clipped.

        Returns:
            Observations; rewards, shape (N,); which episodes are terminated, shape (N,), and
            which truncated; and info.

        Raises:
            BadOptionError: The actions have another shape, or hold what is no finite number.
            ResetNeeded: `reset` has not been called.
            ClosedEnvironmentError: `close` has been called.
        """
        self._check_open()
        if not self.episode.any():
            raise gymnasium.error.ResetNeeded("no episode is under way; call reset()")
        actions = check_action(actions, (self.num_envs, 8))
        begins = self._over
        due = actions
        if self._options.latency:
            due = self._pending[0]
            self._pending = np.concatenate([self._pending[1:], actions[None]])
        perturbations = self._drawn.perturbations
        forces = None if perturbations is None else perturbations[self._rows, self._step]
        diverged = self._batch.step(clip(due) * self._top_speed, forces)
        self._step += 1
        self._begin_episodes()
        return self._outcome(begins, diverged & ~begins, actions)

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self._batch.close()

    def __getstate__(self) -> dict[str, Any]:
        """Refuse to be pickled or copied, as threads cannot be."""
        raise BadOptionError("many environments cannot be pickled or copied; call make_vec() anew")

    def _check_open(self) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError("closed; make another with make_vec()")

    def _mask(self, options: dict[str, Any] | None) -> Mask:
        """Return which members a reset is meant for, shape (N,)."""
        if not options:
            return np.ones(self.num_envs, bool)
        try:
            mask = np.array(options.get("reset_mask")) if isinstance(options, dict) else None
        except ValueError:  # rows of different lengths
            mask = None
        expected = (np.dtype(bool), (self.num_envs,))
        if mask is None or (mask.dtype, mask.shape) != expected or len(options) > 1:
            raise BadOptionError(
                f"options is {options!r}; expected nothing, or a reset_mask of {self.num_envs}"
                " truth values"
            )
        return mask

    def _begin_episodes(self) -> None:
        """Begin an episode for all whose last one is over."""
        for row in np.flatnonzero(self._over).tolist():
            episode = self._demonstration.episode(self._seeds[row], self.episode[row])
            for whole, part in zip(_arrays(self._drawn), _arrays(episode), strict=True):
                whole[row] = part
            self._batch.set_joint_state(row, *self._demonstration.start_of(episode))
            self.episode[row] += 1
            self._step[row] = episode.start
            self._pending[:, row] = 0.0

    def _outcome(
        self, begins: Mask, diverged: Mask, actions: Array
    ) -> tuple[Any, Array, Mask, Mask, dict[str, Any]]:
        posture, now = self._batch.posture(), (self._rows, self._step)
        self.posture = posture.copy()
        terms = closeness(posture, self._drawn.reference[now])
        terms[diverged] = 0.0
        rewards = np.where(begins, 0.0, mean_reward(terms, self._weights))
        too_far = np.zeros(self.num_envs, bool)
        if self._options.termination_distance is not None:
            distance = site_distance(posture, self._drawn.reference[now], self.arms.segment_lengths)
            too_far = (distance > self._options.termination_distance) & ~diverged & ~begins
        terminated = diverged | too_far
        truncated = (self._step >= self.steps) & ~terminated
        self._over = terminated | truncated
        self._termination_reason = np.full(self.num_envs, "", object)
        for reason, ended in ((_DIVERGED, diverged), (TOO_FAR, too_far), (OVER, truncated)):
            self._termination_reason[ended] = reason
        clipped = np.where(begins, 0, np.count_nonzero(np.abs(actions) > 1.0, axis=1))
        by_name = dict(zip(kinematics.SEGMENT_NAMES, terms.T, strict=True))
        info = {
            "reward_terms": self._masked(by_name),
            "clipped": clipped,
            "termination_reason": self._termination_reason.copy(),
        }
        return self._pack(posture), rewards, terminated, truncated, self._masked(info)

    def _pack(self, posture: Array) -> Any:
        self.seen = self._observer.observe(
            self._drawn,
            self._step,
            posture,
            self._batch.joint_angles(),
            self._batch.joint_velocities(),
            (self._rows,),
        )
        return flatten(self.seen, (self.num_envs,)) if self._flat else self.seen

    def _masked(self, info: dict[str, Any]) -> dict[str, Any]:
        """Return info that says by `_name`, as Gymnasium has it, that all members have it."""
        masks = {f"_{name}": np.ones(self.num_envs, bool) for name in info}
        return info | masks


class FlatVectorImitationEnv(VectorImitationEnv):
    """The same with observations of one array, float64, shape (N, 52 + C)."""

    _flat = True


def make_vec(
    num_envs: int, motion: Motion | str | Path = "ymca", *, flat: bool = False, **options: Any
) -> VectorImitationEnv:
    """Return many environments that one call steps together.

    Args:
        num_envs: Number N of environments; member i is that of `load` with seed + i.
        motion: The movement, or what `read_motion` takes: "ymca", or a recording's path.
        flat: Whether observations are one array.
        **options: The fields of `EnvironmentOptions`, such as arms="kinematic".

    Raises:
        BadOptionError: An option is outside what it may be, or there is none of that name.
        MpmaError: The movement cannot be read, or is faster than the arms.
    """
    if not isinstance(flat, bool):
        raise BadOptionError(f"flat is {flat!r}; expected True or False")
    kind = FlatVectorImitationEnv if flat else VectorImitationEnv
    return kind(num_envs, motion=motion, **options)


def _space_for(episode: Episode, count: int) -> Episode:
    """Return arrays for so many episodes like one."""
    noise, perturbations = episode.sensor_noise, episode.perturbations
    return Episode(
        start=0,
        reference=np.zeros((count, *episode.reference.shape)),
        sensor_noise=None if noise is None else np.zeros((count, *noise.shape)),
        perturbations=None if perturbations is None else np.zeros((count, *perturbations.shape)),
    )


def _arrays(episode: Episode) -> list[Array]:
    drawn = (episode.reference, episode.sensor_noise, episode.perturbations)
    return [array for array in drawn if array is not None]
