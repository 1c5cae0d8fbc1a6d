"""Estimate of the arms' state from noisy observations and predictions (Kalman 1960)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.config import JOINTS
from mpma_mj.kinematics import wrap

__all__ = ["StateEstimate"]

Array = NDArray[np.float64]

# Choices; the last two keep an estimate from running away.
_FIRST = 1e-3  # P_0 and S_0, rad²
_RATE = 0.02  # of the running mean square of innovations
_LEAST_NOISE = 1e-8  # Q, rad²
_LEAST_GAIN = 0.05  # κ
_FAR = 5.0  # widths of an innovation from which the observation counts alone


class StateEstimate:
    """Share of observation and prediction in the state, for each joint.

        q̃ = q̂ + κ (q - q̂),   q̇̃ likewise with the same κ
        P⁻ = P + Q,   κ = max(P⁻ / (P⁻ + max(S - P⁻, 0)), C / S),   P = (1 - κ) P⁻

    Q is the variance of the state model's error, S the running mean square of the innovations
    q - q̂, C that of each times the one before. Innovations of the right gain are white (Mehra
    1970): where they are alike from step to step, the model is wrong, as in a plant never met, and
    the observation counts more. Without noise κ is 1. It is bounded from below, and a joint whose
    innovation is beyond five widths is taken as observed.
    """

    def __init__(self, batch_shape: tuple[int, ...]) -> None:
        """Begin with an unknown model error.

        Args:
            batch_shape: Shape of the runs.
        """
        self._noise = np.full((*batch_shape, JOINTS), 1e-4)
        self.reset()

    def reset(self) -> None:
        """Begin an episode with no prediction."""
        self._variance = np.full(self._noise.shape, _FIRST)
        self._innovation = np.full(self._noise.shape, _FIRST)
        self._repeated = np.zeros(self._noise.shape)  # C
        self._last = np.zeros(self._noise.shape)
        self._predicted: tuple[Array, Array] | None = None
        self._steps = 0

    def __call__(self, angles: Array, speed: Array) -> tuple[Array, Array]:
        """Return the estimated joint angles, rad, and relative velocities, each (..., 8).

        Args:
            angles: Observed joint angles, shape (..., 8), rad.
            speed: Observed joint velocities over top speeds, shape (..., 8).
        """
        if self._predicted is None:
            return angles, speed
        predicted, then = self._predicted
        innovation = wrap(angles - predicted)
        far = innovation**2 > _FAR**2 * self._innovation
        self._steps += 1
        rate = max(1.0 / self._steps, _RATE)
        self._innovation += rate * (innovation**2 - self._innovation)
        self._repeated += rate * (innovation * self._last - self._repeated)
        self._last = innovation
        before = self._variance + self._noise
        gain = before / np.maximum(self._innovation, before)
        alike = self._repeated / np.maximum(self._innovation, _LEAST_NOISE)
        gain = np.maximum(gain, np.minimum(alike, 1.0))
        gain = np.where(far, 1.0, np.maximum(gain, _LEAST_GAIN))
        self._variance = (1.0 - gain) * before
        return predicted + gain * innovation, then + gain * (speed - then)

    def predict(self, angles: Array, speed: Array) -> None:
        """Receive the state that is predicted to come next."""
        self._predicted = angles, speed

    def learn(self, error: Array, run: tuple[int, ...]) -> None:
        """Set the model error Q of one run, shape (8,), rad²; only the least so far counts.

        An epoch with noise on the observations would count it as the model's.
        """
        self._noise[run] = np.clip(error, _LEAST_NOISE, self._noise[run])

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._noise = self._noise[runs]

    def state_dict(self) -> dict[str, Array]:
        """Return a copy of the model error."""
        return {"model_error": self._noise.copy()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the array that `state_dict` returned; others are left out."""
        self._noise[...] = state["model_error"]
