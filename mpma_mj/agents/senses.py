"""Senses: the state of the arms that models receive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation
from mpma_mj.agents.state_models import StateModels

__all__ = ["ModelledSenses", "Senses", "Steps"]

Array = NDArray[np.float64]
Steps = dict[str, Array]


class Senses:
    """What is observed, as it is."""

    late: bool = False

    def reset(self, episode: int) -> None:
        """Begin an episode."""

    def __call__(self, observation: Observation, plant: NDArray[np.intp] | int) -> Observation:
        """Return the observation that is expected when the next command acts.

        Args:
            observation: The observation.
            plant: Index of the plant that is most probably on, shape (...).
        """
        return observation

    def present(self, observation: Observation) -> Observation:
        """Return the observation with the state of now, as it is known."""
        return observation

    def of_last_move(self, predictions: Array | None) -> Array | None:
        """Return the predictions, (..., M, K), of the move that has just been observed."""
        return predictions

    def acting(self, observation: Observation, action: Array) -> tuple[Observation, Array]:
        """Receive an action; return present state and the action that acts on it, (..., 8)."""
        return observation, action

    def aligned(self, steps: Steps, last: Steps, run: tuple[int, ...]) -> Steps:
        """Return the steps of one run as causes and effects, each of shape (T', ...).

        Args:
            steps: Steps by name, each of shape (T, ...).
            last: What was observed at the end of the episode, by name.
            run: Index of the run.

        Returns:
            The steps with `next_joint_angles` and `next_posture`.
        """
        following = {
            f"next_{name}": np.concatenate([steps[name][1:], last[name][None]])
            for name in ("joint_angles", "posture")
        }
        return steps | following

    def effects(self, predictions: Array) -> Array:
        """Return predictions, shape (T, ...), at the steps at which their commands act."""
        return predictions

    def learn(self, steps: Steps, shares: Array, run: tuple[int, ...]) -> None:
        """Learn from the aligned steps of one run.

        Args:
            steps: As `aligned` returned them.
            shares: Which plant was on, shape (T', W).
            run: Index of the run.
        """

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return {}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""


class ModelledSenses(Senses):
    """What is observed, as it is, and models of the state for a latency that may come later."""

    def __init__(self, spec: AgentSpec, batch_shape: tuple[int, ...], plants: int) -> None:
        """Begin with the kinematic prior; arguments as of `StateModels`."""
        self._spec = spec
        self._models = StateModels(spec, batch_shape, plants)
        self._velocities: list[Array] = []

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        self._velocities = []

    def __call__(self, observation: Observation, plant: NDArray[np.intp] | int) -> Observation:
        """Return the observation."""
        self._velocities.append(observation["joint_velocities"])
        return observation

    def aligned(self, steps: Steps, last: Steps, run: tuple[int, ...]) -> Steps:
        """Return the steps of one run as causes and effects, with joint velocities."""
        own: tuple[Any, ...] = (slice(None), *run)
        velocities = np.stack(self._velocities)[own]
        after = np.concatenate([velocities[1:], last["joint_velocities"][None]])
        observed = {"joint_velocities": velocities, "next_joint_velocities": after}
        return super().aligned(steps, last, run) | observed

    def learn(self, steps: Steps, shares: Array, run: tuple[int, ...]) -> None:
        """Refit the state models."""
        self._models.learn(steps, shares, run)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._models.select_runs(runs)

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return self._models.state_dict()

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self._models.load_state_dict(state)
