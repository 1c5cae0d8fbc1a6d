"""Observations of one pair of arms or of many."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from mpma_mj.envs.demonstration import Demonstration, Episode
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.step_rules import Steps

__all__: list[str] = ["Observer"]

Array = NDArray[np.float64]


class Observer:
    """Composes observations from the demonstration and the state of the arms.

    Attributes:
        shapes: Shape of each array of an observation, by name.
    """

    def __init__(self, demonstration: Demonstration, options: EnvironmentOptions) -> None:
        """Take context, phase and the choice of observations.

        Args:
            demonstration: The demonstration.
            options: Options of the environment.
        """
        self._context, self._phase = demonstration.context, demonstration.phase
        self._lookahead, self._shows_phase = options.lookahead, options.phase
        self.shapes: dict[str, tuple[int, ...]] = {
            **{"posture": (12,), "reference": (12,), "target": (12,)},
            "context": self._context.shape[1:],
            **{"joint_angles": (8,), "joint_velocities": (8,)},
        }
        if self._lookahead:
            self.shapes["lookahead"] = (self._lookahead, 12)
        if self._shows_phase:
            self.shapes["phase"] = (2,)

    def observe(
        self,
        episode: Episode,
        step: Steps,
        posture: Array,
        joint_angles: Array,
        joint_velocities: Array,
        rows: tuple[NDArray[np.intp], ...] = (),
    ) -> dict[str, Array]:
        """Return an observation, whose arrays are not shared with anything.

        Args:
            episode: The episode; a batch of N episodes for N pairs of arms.
            step: Step of the demonstration; shape (N,) for N pairs of arms.
            posture: Posture of the arms, shape (..., 12); becomes part of the observation.
            joint_angles: Joint angles, shape (..., 8), rad; as the posture.
            joint_velocities: Joint velocities, shape (..., 8), rad/s; as the posture.
            rows: For N pairs of arms, their indices in the batch of episodes, shape (N,).
        """
        now, after = (*rows, step), (*rows, step + 1)
        if episode.sensor_noise is not None:
            noise = episode.sensor_noise[now]
            posture = _unit(posture + noise[..., :12])
            joint_angles = joint_angles + noise[..., 12:20]
            joint_velocities = joint_velocities + noise[..., 20:]
        observation = {
            "posture": posture,
            "reference": episode.reference[now].copy(),
            "target": episode.reference[after].copy(),
            "context": self._context[step].copy(),
            "joint_angles": joint_angles,
            "joint_velocities": joint_velocities,
        }
        if self._lookahead:
            windows = sliding_window_view(episode.reference, self._lookahead, axis=-2)
            observation["lookahead"] = np.moveaxis(windows[after], -1, -2).copy()
        if self._shows_phase:
            observation["phase"] = self._phase[step].copy()
        return observation


def _unit(posture: Array) -> Array:
    """Return a posture, shape (..., 12), with its four vectors normalised."""
    vectors = posture.reshape(*posture.shape[:-1], 4, 3)
    length = np.sqrt(np.vecdot(vectors, vectors))
    return (vectors / length[..., None]).reshape(posture.shape)
