"""MPMA with the true plant: an upper bound on distinguishing plants."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Observation
from mpma_mj.agents.config import AgentConfig, OracleConfig
from mpma_mj.agents.mpma import MPMA
from mpma_mj.agents.networks import RunIndex
from mpma_mj.agents.plant_gate import PlantGate
from mpma_mj.agents.plant_models import PlantModels
from mpma_mj.errors import BadOptionError

__all__ = ["Oracle"]

Array = NDArray[np.float64]


class _ObservingGate(PlantGate):
    """`PlantGate` that receives the plant instead of a belief, and has modules for all of them.

    Attributes:
        true_plant: Index of the plant that is on, shape (...); the first until it is given.
    """

    true_plant: NDArray[np.intp]

    def __init__(self, *args: Any, **options: Any) -> None:
        """Draw the responsibility predictors, and let all plants prefer alike."""
        super().__init__(*args, **options)
        self.models.recruited[...] = self.models.most
        self._preferences[...] = self._preferences[..., :1, :, :]
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self.true_plant = np.zeros_like(self.models.recruited)
        self._true_plants: list[NDArray[np.intp]] = []

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors and responsibilities of a step, each of shape (..., W · M)."""
        self._true_plants.append(self.true_plant)
        self._possible = self.true_plant[..., None] == np.arange(self.plants)
        self._belief = self._possible.astype(float)
        return super().__call__(observation, predictions)

    def _posterior(
        self, run: RunIndex, models: PlantModels, inputs: Array, outcome: Array
    ) -> Array:
        """Return which plant was on in each step of one run, shape (T, W)."""
        models.epochs[...] += 1
        # Where senses are late, no command acted in the first steps.
        plants = np.array([step[run] for step in self._true_plants])[-len(outcome) :]
        return (plants[:, None] == np.arange(models.most)).astype(float)

    def _believed(self, before: Array, move: Array) -> Array:
        """Return the belief b, which no move changes."""
        return before


class Oracle(MPMA):
    """`MPMA` that observes which plant is on, and has a set of modules for each."""

    config_type: ClassVar[type[AgentConfig]] = OracleConfig
    gate_type: ClassVar[type[PlantGate]] = _ObservingGate
    observes_plant: bool = True
    _gate: _ObservingGate

    def observe_plant(self, plant: NDArray[np.intp] | None) -> None:
        """Receive the index of the plant that is on, shape (...), before each action.

        Raises:
            BadOptionError: There are more plants than the agent may have.
        """
        true_plant = np.zeros(self._batch_shape, np.intp) if plant is None else np.asarray(plant)
        number, most = int(true_plant.max()) + 1, self._gate.models.most
        if number > most:
            expected = f"at least {number}, one for each plant of the environment"
            raise BadOptionError(option="max_plants", value=most, expected=expected)
        self._gate.true_plant = true_plant
