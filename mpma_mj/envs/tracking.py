"""Tracking errors of the episodes of many environments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.envs.step_rules import Mask

__all__: list[str] = ["Tracking"]

Array = NDArray[np.float64]


class Tracking:
    """Recorder of the postures of N environments, which measures episodes at their end."""

    def __init__(self, count: int, steps: int, keypoints: Array) -> None:
        """Make room for the episodes.

        Args:
            count: Number N of environments.
            steps: Number of steps of the demonstration.
            keypoints: Matrix that takes postures to positions of elbows and wrists, (12, 12), m.
        """
        self._keypoints = keypoints
        self._rows = np.arange(count)
        self._start = np.zeros(count, int)
        self._postures = np.zeros((count, steps + 1, 12))  # by step of the demonstration

    def begin(self, row: int, start: int) -> None:
        """Begin an episode of one environment at this step of the demonstration."""
        self._start[row] = start

    def record(self, step: NDArray[np.intp], posture: Array) -> None:
        """Record the postures, shape (N, 12), at these steps of the demonstration, shape (N,)."""
        self._postures[self._rows, step] = posture

    def errors(self, over: Mask, step: NDArray[np.intp], reference: Array) -> dict[str, Array]:
        """Return `p_e_percent` and `mpkpe_m` of episodes, each shape (N,); see `metrics`.

        Args:
            over: Which episodes to measure, shape (N,); the others have 0.
            step: Steps of the demonstration up to which to measure, shape (N,).
            reference: Demonstrated postures, shape (N, T, 12).
        """
        errors: dict[str, Array] = {}
        for row in np.flatnonzero(over):
            now = row, slice(self._start[row] + 1, step[row] + 1)
            found = metrics.tracking_errors(self._postures[now], reference[now], self._keypoints)
            for name, error in found.items():
                errors.setdefault(name, np.zeros(len(reference)))[row] = error
        return errors
