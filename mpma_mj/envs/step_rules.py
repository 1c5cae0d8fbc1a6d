"""Rules of a control step, for one pair of arms and for many: actions, outcome, endings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.reward import mean_reward, reward_weights, segment_rewards, site_distance
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.clipping import clip

__all__: list[str] = [
    "DIVERGED",
    "OVER",
    "TOO_FAR",
    "Mask",
    "Outcome",
    "StepRules",
    "Steps",
    "check_action",
    "count_clipped",
    "delayed",
    "top_speeds",
]

Array = NDArray[np.float64]
Mask = np.bool_ | NDArray[np.bool_]
Steps = np.intp | NDArray[np.intp]

DIVERGED = "the simulation diverged"
TOO_FAR = "an elbow or wrist is too far from the demonstrated place"
OVER = "the demonstration is over"
_REASONS = np.array(["", OVER, TOO_FAR, DIVERGED], object)

_NO = np.False_


class Outcome(NamedTuple):
    """Outcome of a control step, of one pair of arms or of many.

    Attributes:
        reward_terms: Terms of the reward in the order of `SEGMENT_NAMES`, in [0, 1], (..., 4).
        reward: Weighted mean of the terms, shape (...).
        diverged: Whether the simulation diverged, shape (...).
        terminated: Whether it diverged or the arms are too far from the demonstration, shape (...).
        ended: Whether the episode is terminated or the demonstration is over, shape (...).
    """

    reward_terms: Array
    reward: Array
    diverged: Mask
    terminated: Mask
    ended: Mask

    @property
    def truncated(self) -> Mask:
        """Whether the episode ends with the demonstration, shape (...)."""
        return self.ended ^ self.terminated

    @property
    def termination_reason(self) -> Any:
        """Why the episode ends, empty where it continues: a string, or strings, shape (...)."""
        return _REASONS[0 + self.ended + self.terminated + self.diverged]


class StepRules:
    """Rules of the control steps of an environment."""

    def __init__(
        self,
        options: EnvironmentOptions,
        steps: int,
        top_speeds: Array,
        segment_lengths: Array,
    ) -> None:
        """Take the parameters of the rules.

        Args:
            options: Options of the environment.
            steps: Step at which the demonstration is over.
            top_speeds: Joint velocities that action 1 commands, shape (8,), rad/s.
            segment_lengths: Lengths of the four segments, shape (4,), m.
        """
        self._steps = steps
        self._segment_lengths = segment_lengths
        self._termination_distance = options.termination_distance
        self._weights = reward_weights(options.reward_weights)
        self._top_speeds = top_speeds

    def joint_velocities(self, action: Array) -> Array:
        """Return the joint velocities that an action commands, shape (..., 8), rad/s."""
        return clip(action) * self._top_speeds

    def outcome(
        self,
        posture: Array,
        reference: Array,
        step: Steps,
        diverged: Mask = _NO,
        begins: Mask = _NO,
    ) -> Outcome:
        """Return the outcome of a control step.

        An episode ends for the first reason that holds: the simulation diverged, the arms are too
        far from the demonstration, the demonstration is over.

        Args:
            posture: Postures after the step, shape (..., 12).
            reference: Demonstrated postures after the step, shape (..., 12).
            step: Steps of the demonstration so far, shape (...).
            diverged: Whether the simulation diverged, shape (...); its terms are 0.
            begins: Whether an episode begins here, shape (...): its reward is 0 and it does not
                end.
        """
        terms = segment_rewards(posture, reference)
        if diverged is not _NO:  # one pair of arms is spared the time
            terms[diverged] = 0.0
        reward = mean_reward(terms, self._weights)
        terminated = diverged
        if self._termination_distance is not None:
            distance = site_distance(posture, reference, self._segment_lengths)
            terminated = diverged | (distance > self._termination_distance)
        ended = terminated | (step >= self._steps)
        if begins is not _NO:
            reward, terminated, ended = reward * ~begins, terminated & ~begins, ended & ~begins
        return Outcome(terms, reward, diverged, terminated, ended)


def check_action(action: ArrayLike, shape: tuple[int, ...] = (8,)) -> Array:
    """Return an action as float64.

    Args:
        action: Joint velocities over the joints' top speeds, shape (..., 8).
        shape: Expected shape.

    Raises:
        BadOptionError: The action has another shape or type, or an entry is no finite number;
            names the entry.
    """
    try:
        given = np.asarray(action)
    except ValueError:  # rows of different lengths
        raise BadOptionError(f"action is not an array; expected shape {shape}") from None
    if given.dtype.kind not in "fiu":
        raise BadOptionError(f"action is of type {given.dtype}; expected float64, shape {shape}")
    if given.shape != shape:
        raise BadOptionError(f"action has shape {given.shape}; expected {shape}")
    values = np.asarray(given, np.float64)
    # The sum of squares is finite only if all entries are, and costs a third of `isfinite`.
    if not np.vdot(values, values) < np.inf:
        unfit = np.argwhere(~np.isfinite(values))
        if len(unfit):
            entry = ", ".join(map(str, unfit[0]))
            raise BadOptionError(
                f"action[{entry}] is {values[tuple(unfit[0])]}; expected numbers in [-1, 1]"
            )
    return values


def top_speeds(max_joint_speed: Array, joints: Sequence[str], locked_joint: str | None) -> Array:
    """Return the joint velocities that action 1 commands, shape (8,), rad/s.

    Args:
        max_joint_speed: Top speeds of the joints, shape (8,), rad/s.
        joints: Names of the joints.
        locked_joint: Name of the joint that is held fixed, None for none.
    """
    return np.where([name == locked_joint for name in joints], 0.0, max_joint_speed)


def delayed(pending: Array, action: Array, latency: Steps | None = None) -> tuple[Array, Array]:
    """Return the action that takes effect now, and those that may do so after it.

    Where the latency rises by some steps, as many actions take effect again; where it falls, as
    many are skipped.

    Args:
        pending: Last actions before the latest, oldest first, shape (longest latency, ..., 8).
        action: Latest action, shape (..., 8).
        latency: How many steps ago the action that takes effect was given, shape (...); the
            longest if not given.
    """
    if not len(pending):
        return action, pending
    queue = np.concatenate([pending, action[None]])
    if latency is None:
        return queue[0], queue[1:]
    return queue[(len(pending) - latency, *np.indices(np.shape(latency)))], queue[1:]


def count_clipped(action: Array) -> NDArray[np.intp]:
    """Return how many entries of an action, shape (..., 8), are outside [-1, 1], shape (...)."""
    return np.count_nonzero(np.abs(action) > 1.0, axis=-1)
