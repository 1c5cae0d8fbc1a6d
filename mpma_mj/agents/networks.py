"""Echo state networks of all modules, with their record of an episode."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Seeds
from mpma_mj.agents.config import HAMMERConfig, MPMAConfig, NetworkConfig
from mpma_mj.agents.episode_buffer import EpisodeBuffer
from mpma_mj.esn import PRECISION, FeatureReplay, Features, ReadoutBank, ReservoirBank, Ridge
from mpma_mj.utils.seeding import stream

__all__ = ["Network", "NetworkFactory", "RunIndex"]

Array = NDArray[np.float64]
RunIndex = tuple[int, ...]  # index of a run; () where there is one

_MOST_KEPT = 2**26  # bytes of features of each network; those of more steps are replayed (choice)
_LEAST_RIDGE = 1e-6  # per step, added to a relative ridge (choice)


@dataclass(frozen=True)
class NetworkFactory:
    """Common properties of all networks of an agent.

    Attributes:
        config: Config of the networks.
        seed: Seed of weights and noise; several are a batch of runs.
        modules: Number of modules, M.
        forgetting: Forgetting φ of the readouts, where they are fitted.
        ridge: Ridge ρ of the readouts, where they are fitted.
        inverse_ridge: Ridge of the inverse models, where it is relative to each feature; 0 where it
            is not.
        max_plants: Largest number of plants, each with as many modules.
    """

    config: NetworkConfig
    seed: Seeds
    modules: int
    forgetting: float = 0.0
    ridge: float = 1.0
    inverse_ridge: float = 0.0
    max_plants: int = 1

    @classmethod
    def fitted(
        cls, config: MPMAConfig | HAMMERConfig, seed: Seeds, modules: int, forgetting: float
    ) -> NetworkFactory:
        """Return the properties of networks whose readouts are fitted with the config's ridges."""
        inverse_ridge = config.inverse_ridge if config.models == "joint" else 0.0
        return cls(config, seed, modules, forgetting, config.ridge, inverse_ridge)

    def make(self, name: str, inputs: int, outputs: int) -> Network:
        """Draw a network for each module.

        Args:
            name: Name of their random streams.
            inputs: Size of the input.
            outputs: Size of the output.
        """
        relative = name == "inverse" and self.inverse_ridge > 0.0
        ridge = Ridge(_LEAST_RIDGE, self.inverse_ridge) if relative else Ridge(self.ridge)
        return Network(self, name, inputs, outputs, ridge)

    def make_shared(self, name: str, inputs: int, outputs: int) -> Network:
        """Draw a network for each module that modules of all plants share; see `make`."""
        return dataclasses.replace(self, max_plants=1).make(name, inputs, outputs)


class Network:
    """Reservoirs and readouts of one kind, one pair for each of M modules.

        z_n = reservoir(v_n)          output = W_out z_n

    W_out is 0 at first. Features of an episode are kept for learning, or, where they are too many,
    its inputs alone: then they are computed once more.

    Attributes:
        readouts: Readouts, of weights of shape (..., M, K, F).
        plants: Number of plants whose reservoirs are drawn.
        features: Features z of the last step, shape (..., M, F).
    """

    plants: int
    _reservoirs: ReservoirBank

    def __init__(
        self, common: NetworkFactory, name: str, inputs: int, outputs: int, ridge: Ridge
    ) -> None:
        """Draw the reservoirs of the first plant; see `NetworkFactory.make`."""
        self._common, self._inputs = common, inputs
        self._name, self._episode = name, 0
        self._batch_shape = batch_shape = np.shape(common.seed)
        self._seeds: list[int] = np.ravel(common.seed).tolist()
        self._draw_first()
        modules = common.max_plants * common.modules
        shape = (*batch_shape, modules, outputs, self._reservoirs.features)
        self.readouts = ReadoutBank(np.zeros(shape), forgetting=common.forgetting, ridge=ridge)
        self.features: Features
        self._steps = EpisodeBuffer()
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with reservoirs at rest and that episode's noise."""
        self._episode = episode
        by_run = [self._noise(seed, episode) for seed in self._seeds]
        self._reservoirs.reset(*zip(*by_run, strict=True))
        self._shape = self._reservoirs.shape
        self._most_kept = max(1, _MOST_KEPT // (math.prod(self._shape) * PRECISION().itemsize))
        self._steps.clear()

    def set_plants(self, count: int) -> None:
        """Draw the reservoirs of further plants, or remove some, until there are so many.

        They step from the next reset; `replay` contains them at once.
        """
        if count < self.plants:
            self._draw_first()
        for plant in range(self.plants, count):
            streams = [stream(seed, "reservoir", self._name, plant) for seed in self._seeds]
            self._reservoirs.extend(streams)
        self.plants = count

    def step(self, inputs: Array) -> Array:
        """Update the reservoirs and return the readouts' output.

        Args:
            inputs: Input v, shape (..., D) for all modules alike or (..., M, D).

        Returns:
            Output, shape (..., M, K).
        """
        steps = self._steps
        steps.reserve("inputs", inputs.shape, PRECISION)[...] = inputs
        place = steps.reserve("features", self._shape, PRECISION, self._most_kept)
        self.features = self._reservoirs.step(inputs, place)
        steps.append({})
        return self.readouts(self.features)

    def episode(self, run: RunIndex, modules: int) -> Features | FeatureReplay:
        """Return one run's features of the episode, shape (T, M', F), of a number of modules."""
        own: tuple[Any, ...] = (slice(None), *run)
        steps = self._steps.episode()
        if "features" in steps and steps["features"].shape[-2] >= modules:
            return steps["features"][own]
        return self.replay(run, steps["inputs"][own])

    def replay(self, run: RunIndex, inputs: Array) -> FeatureReplay:
        """Return one run's features for other inputs, shape (T, D), with the episode's noise."""
        seed = self._seeds[run[0] if run else 0]
        noise = functools.partial(self._noise, seed, self._episode)
        return FeatureReplay(self._reservoirs.of_run(run), noise, inputs)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._seeds = [self._seeds[i] for i in runs]
        self._batch_shape = runs.shape
        self._reservoirs.select_runs(runs)
        self.readouts.select_runs(runs)
        self._steps = EpisodeBuffer()

    def state_dict(self) -> dict[str, Array]:
        """Return copies of the readouts' arrays by name."""
        return {f"{self._name}.{n}": value for n, value in self.readouts.state_dict().items()}

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self.readouts.load_state_dict(state, f"{self._name}.")

    def _noise(self, seed: int, episode: int) -> list[np.random.Generator]:
        """Return the source of one run's noise for each plant."""
        path = ("reservoir_noise", self._name, episode)
        return [stream(seed, *path, *([plant] if plant else [])) for plant in range(self.plants)]

    def _draw_first(self) -> None:
        """Draw the reservoirs of the first plant alone."""
        config = self._common.config
        self.plants = 1
        self._reservoirs = ReservoirBank(
            self._batch_shape,
            self._common.modules,
            self._inputs,
            config.nodes,
            radius=config.spectral_radius,
            noise=config.reservoir_noise,
            streams=[stream(seed, "reservoir", self._name) for seed in self._seeds],
        )
