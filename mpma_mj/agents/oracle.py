"""MPMA that is told which plant is on: the best that telling plants apart could reach."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import AgentSpec, Observation
from mpma_mj.agents.config import AgentConfig, MPMAConfig, OracleConfig
from mpma_mj.agents.mpma import MPMA
from mpma_mj.agents.networks import NetworkFactory, RunIndex
from mpma_mj.agents.plant_gate import PlantGate
from mpma_mj.agents.plant_models import PlantModels
from mpma_mj.errors import BadOptionError

__all__ = ["Oracle"]

Array = NDArray[np.float64]


class _ToldGate(PlantGate):
    """`PlantGate` that receives the plant instead of a belief, and has modules for all of them.

    Attributes:
        told: Index of the plant that is on, shape (...); of the first until it is told.
    """

    told: NDArray[np.intp]

    def __init__(self, networks: NetworkFactory, config: MPMAConfig, spec: AgentSpec) -> None:
        """Draw the responsibility predictors, and let all plants prefer alike."""
        super().__init__(networks, config, spec)
        self.models.recruited[...] = self.models.most
        self._preferences[...] = self._preferences[..., :1, :, :]
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode."""
        super().reset(episode)
        self.told = np.zeros_like(self.models.recruited)
        self._told: list[NDArray[np.intp]] = []

    def __call__(self, observation: Observation, predictions: Array | None) -> tuple[Array, Array]:
        """Return priors and responsibilities of a step, each of shape (..., W · M)."""
        self._told.append(self.told)
        self._possible = self.told[..., None] == np.arange(self.plants)
        self._belief = self._possible.astype(float)
        return super().__call__(observation, predictions)

    def _posterior(
        self, run: RunIndex, models: PlantModels, inputs: Array, outcome: Array
    ) -> Array:
        """Return which plant was on in each step of one run, shape (T, W)."""
        models.epochs[...] += 1
        # Where senses are late, no command acted in the first steps.
        told = np.array([step[run] for step in self._told])[-len(outcome) :]
        return (told[:, None] == np.arange(models.most)).astype(float)

    def _believed(self, before: Array, move: Array) -> Array:
        """Return the belief b, which no move changes."""
        return before


class Oracle(MPMA):
    """`MPMA` that is told which plant is on, and has a set of modules for each."""

    config_type: ClassVar[type[AgentConfig]] = OracleConfig
    gate_type: ClassVar[type[PlantGate]] = _ToldGate
    is_told_plant: bool = True
    _gate: _ToldGate

    def tell_plant(self, plant: NDArray[np.intp] | None) -> None:
        """Receive the index of the plant that is on, shape (...), before each action.

        Raises:
            BadOptionError: There are more plants than the agent may have.
        """
        told = np.zeros(self._batch_shape, np.intp) if plant is None else np.asarray(plant)
        most = self._gate.models.most
        if told.max() >= most:
            expected = f"at least {int(told.max()) + 1}, one for each plant of the environment"
            raise BadOptionError(option="max_plants", value=most, expected=expected)
        self._gate.told = told
