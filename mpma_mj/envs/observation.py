"""Observations of one pair of arms or of many, and Gymnasium's spaces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from mpma_mj.envs.demonstration import Demonstration, Episode
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.step_rules import Steps
from mpma_mj.feedback import followed, joint_error

__all__: list[str] = ["Observer", "action_space", "flatten", "observation_space"]

Array = NDArray[np.float64]

# Coordinates of unit vectors, sines and cosines may be rounded to a little more than 1.
_UNIT = (-1.0 - 1e-9, 1.0 + 1e-9)
_BOUNDS: dict[str, tuple[float, float]] = dict.fromkeys(
    ("posture", "reference", "target", "lookahead", "phase"), _UNIT
)
_BOUNDS["context"] = (0.0, 1.0)
# Shoulders have no limits and simulated arms overshoot theirs. A finite bound, however large, would
# let wrappers rescale angles and velocities to nothing, instead of refusing.
_NO_BOUND = (-np.inf, np.inf)


class Observer:
    """Composes observations from the demonstration and the state of the arms.

    Attributes:
        shapes: Shape of each array of an observation, by name.
    """

    def __init__(self, demonstration: Demonstration, options: EnvironmentOptions) -> None:
        """Take context and phase of the demonstration, and the choice of observations."""
        self._context, self._phase = demonstration.context, demonstration.phase
        self._kinematics = demonstration.kinematics
        self._lookahead, self._shows_phase = options.lookahead, options.phase
        self._shows_move, self._largest_move = options.error_observation, demonstration.largest_move
        self.shapes: dict[str, tuple[int, ...]] = {
            **{"posture": (12,), "reference": (12,), "target": (12,)},
            "context": self._context.shape[1:],
            **{"joint_angles": (8,), "joint_velocities": (8,)},
        }
        if demonstration.has_angles:
            self.shapes |= {"reference_angles": (8,), "target_angles": (8,)}
        if self._lookahead:
            self.shapes["lookahead"] = (self._lookahead, 12)
            if demonstration.has_angles:
                self.shapes["lookahead_angles"] = (self._lookahead, 8)
        if self._shows_phase:
            self.shapes["phase"] = (2,)
        if self._shows_move:
            self.shapes["move"] = (8,)

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
        if episode.reference_angles is not None:
            observation["reference_angles"] = episode.reference_angles[now].copy()
            observation["target_angles"] = episode.reference_angles[after].copy()
        if self._lookahead:
            observation["lookahead"] = self._ahead(episode.reference, after)
            if episode.reference_angles is not None:
                observation["lookahead_angles"] = self._ahead(episode.reference_angles, after)
        if self._shows_phase:
            observation["phase"] = self._phase[step].copy()
        if self._shows_move:
            target = followed(observation, "target")
            error = joint_error(joint_angles, target, self._kinematics)
            observation["move"] = error / self._largest_move
        return observation

    def _ahead(self, shown: Array, after: tuple[Any, ...]) -> Array:
        """Return the next targets, shape (..., N, 12 or 8), from an index on."""
        windows = sliding_window_view(shown, self._lookahead, axis=-2)
        return np.moveaxis(windows[after], -1, -2).copy()


def action_space() -> spaces.Box[np.float32]:
    """Return the space of actions, float32 as learners expect."""
    return spaces.Box(-1.0, 1.0, (8,))


def observation_space(shapes: Mapping[str, tuple[int, ...]], *, flat: bool) -> spaces.Space[Any]:
    """Return the space of observations.

    Args:
        shapes: Shape of each array of an observation, by name.
        flat: Whether observations are one array, the concatenation of the others.
    """
    parts = {}
    for name, shape in shapes.items():
        low, high = _BOUNDS.get(name, _NO_BOUND)
        parts[name] = spaces.Box(low, high, shape, dtype=np.float64)
    if not flat:
        return spaces.Dict(list(parts.items()))  # a dictionary would be sorted
    lowest = np.concatenate([part.low.ravel() for part in parts.values()])
    highest = np.concatenate([part.high.ravel() for part in parts.values()])
    return spaces.Box(lowest, highest, dtype=np.float64)


def flatten(observation: Mapping[str, Array], batch: tuple[int, ...] = ()) -> Array:
    """Return an observation as one array, shape (*batch, sum of the sizes)."""
    return np.concatenate([part.reshape(*batch, -1) for part in observation.values()], axis=-1)


def _unit(posture: Array) -> Array:
    """Return a posture, shape (..., 12), with its four vectors normalised."""
    vectors = posture.reshape(*posture.shape[:-1], 4, 3)
    length = np.sqrt(np.vecdot(vectors, vectors))
    return (vectors / length[..., None]).reshape(posture.shape)
