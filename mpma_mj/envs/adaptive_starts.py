"""Starts of episodes, more often where past episodes missed reward."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.step_rules import Mask, Steps
from mpma_mj.utils.seeding import stream

__all__: list[str] = ["AdaptiveStarts"]

Array = NDArray[np.float64]

_SECTIONS = 16  # of the motion (choice)
_RATE = 0.2  # of the average over episodes (choice)
_FLOOR = 0.2  # of the mean over sections (choice)
_LEAST_ERROR = 1e-12  # so that sections without error are equal


class AdaptiveStarts:
    """Starts by the errors of N environments, each of which has its own.

    The error of a section of the motion is 1 - reward, averaged over the steps that an episode took
    there, and over episodes:

        e ← e + 0.2 (e_episode - e)        the first e_episode itself
        w = e + 0.2 mean(e)

    An episode starts at any step with a probability in proportion to the weight w of its section. A
    section that was not reached counts as the worst one that was. Episode 0 begins without errors.
    """

    def __init__(self, count: int, demonstration: Demonstration) -> None:
        """Divide the motion of N environments into sections."""
        steps, period = demonstration.steps, demonstration.period
        self._section = np.arange(steps + 1) % period * _SECTIONS // period  # (T,)
        self._errors = np.full((count, _SECTIONS), np.nan)
        self._sums, self._steps = np.zeros((2, count, _SECTIONS))

    @classmethod
    def if_chosen(
        cls, options: EnvironmentOptions, count: int, demonstration: Demonstration
    ) -> AdaptiveStarts | None:
        """Return the starts of N environments where the option `random_start` is adaptive."""
        return cls(count, demonstration) if options.random_start == "adaptive" else None

    def record(self, step: Steps, reward: Array, moved: Mask) -> None:
        """Record the outcome of a step.

        Args:
            step: Steps of the demonstration, shape (N,).
            reward: Rewards, shape (N,).
            moved: Which environments took a step, shape (N,).
        """
        rows = np.flatnonzero(moved)
        sections = self._section[step][rows]
        self._sums[rows, sections] += 1.0 - reward[rows]
        self._steps[rows, sections] += 1.0

    def begin(self, row: int, seed: int, episode: int) -> int:
        """Return the step at which the next episode of an environment starts.

        Args:
            row: Index of the environment.
            seed: Seed of everything random.
            episode: Number of the episode, from 0.
        """
        errors, sums, steps = self._errors[row], self._sums[row], self._steps[row]  # views
        if episode == 0:
            errors[:] = np.nan
        else:
            seen = steps > 0
            latest, known = sums[seen] / steps[seen], errors[seen]
            errors[seen] = np.where(np.isnan(known), latest, known + _RATE * (latest - known))
        sums[:], steps[:] = 0.0, 0.0
        weights = _weights(errors)[self._section[:-1]]
        rng = stream(seed, "start", episode)
        return int(rng.choice(len(weights), p=weights / weights.sum()))


def _weights(errors: Array) -> Array:
    """Return the weights of sections, shape (S,), from their errors, NaN where unknown."""
    if np.isnan(errors).all():
        return np.ones_like(errors)
    errors = np.where(np.isnan(errors), np.nanmax(errors), errors)
    return errors + _FLOOR * max(float(errors.mean()), _LEAST_ERROR)
