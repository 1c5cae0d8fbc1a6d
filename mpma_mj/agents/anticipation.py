"""Anticipation: a reservoir that predicts the coming demonstration where it is not shown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import Observation, Seeds
from mpma_mj.agents.config import POSTURE, NetworkConfig
from mpma_mj.agents.networks import NetworkFactory, RunIndex

__all__ = ["Anticipation"]

Array = NDArray[np.float64]

# Choices: a longer memory than the models', and little noise.
_NODES, _SPECTRAL_RADIUS, _NOISE = 200, 0.9, 0.02
_RIDGE, _SPEED = 1e-4, 5.0


class Anticipation:
    """Targets of the next steps, from those shown so far.

        x̂'_{t+1+j} = unit(x'_{t+1} + W_j z_t),   z = reservoir([x'_{t+1} ; 5 (x'_{t+1} - x'_t) ; y])

    for j from 1 to a largest one. W_j is 0 at first, so that the target is held, and is fitted to
    all episodes so far by ridge regression.
    """

    def __init__(self, context_size: int, seed: Seeds, most: int, nodes: int = _NODES) -> None:
        """Draw the reservoir.

        Args:
            context_size: Number of the context's entries.
            seed: Seed of weights and noise; several are a batch of runs.
            most: Largest number of steps ahead.
            nodes: Number of its neurons.
        """
        self._most = most
        config = NetworkConfig(
            nodes=nodes, spectral_radius=_SPECTRAL_RADIUS, reservoir_noise=_NOISE
        )
        factory = NetworkFactory(config, seed, 1, forgetting=1.0, ridge=_RIDGE)
        inputs = 2 * POSTURE + context_size
        self._network = factory.make("anticipation", inputs, most * POSTURE)
        self.reset(0)

    def reset(self, episode: int) -> None:
        """Begin an episode with the reservoir at rest."""
        self._network.reset(episode)
        self._targets: list[Array] = []

    def __call__(self, observation: Observation) -> Array:
        """Return the targets of the next steps, shape (..., most + 1, 12), the first as shown."""
        target = observation["target"]
        before = self._targets[-1] if self._targets else observation["reference"]
        self._targets.append(target)
        inputs = [target, _SPEED * (target - before), observation["context"]]
        outputs = self._network.step(np.concatenate(inputs, axis=-1))[..., 0, :]
        ahead = target[..., None, :] + outputs.reshape(*target.shape[:-1], self._most, POSTURE)
        vectors = ahead.reshape(*ahead.shape[:-1], 4, 3)
        unit = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
        return np.concatenate([target[..., None, :], unit.reshape(ahead.shape)], axis=-2)

    def learn(self, run: RunIndex) -> None:
        """Learn from one run's episode, as far as the coming targets are known."""
        own: tuple[Any, ...] = (slice(None), *run)
        targets = np.stack(self._targets)[own]
        known = len(targets) - self._most
        if known < 1:
            return
        coming = [targets[j : j + known] - targets[:known] for j in range(1, self._most + 1)]
        weights = (np.arange(len(targets)) < known).astype(float)[:, None]
        offsets = np.zeros((len(targets), 1, self._most * POSTURE))
        offsets[:known, 0] = np.concatenate(coming, axis=-1)
        features = self._network.episode(run, 1)
        self._network.readouts.of_run(run).fit(features, offsets, weights)

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        self._network.select_runs(runs)

    def state_dict(self) -> dict[str, Array]:
        """Return copies of all arrays that learning changes, by name."""
        return self._network.state_dict()

    def load_state_dict(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays that `state_dict` returned; others are left out."""
        self._network.load_state_dict(state)
