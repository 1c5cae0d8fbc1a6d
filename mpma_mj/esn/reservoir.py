"""Banks of echo state reservoirs that step together, and features that they compute again."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mpma_mj.esn.initializers import block_diagonal, random_recurrence

__all__ = ["PRECISION", "FeatureReplay", "Features", "ReservoirBank", "Single", "blocks"]

PRECISION = np.float32
Single = NDArray[np.float32]
Features = NDArray[np.floating[Any]]
"""Input of readouts, of any precision."""

Array = NDArray[np.float64]
Streams = Sequence[np.random.Generator]

# Steps for which noise is drawn at once; the noise does not depend on it.
_DRAWN_AHEAD = 64

# Up to this number of neurons one product with a full matrix is faster than one with a sparse
# matrix and one with the input weights. They sum in another order, so that results of larger
# reservoirs stay as they were (choice).
_FULL = 50


class ReservoirBank:
    """A number of independent reservoirs in stacked arrays.

        s_n = tanh(W s_{n-1} + W_in v_n) + ν · U(-½, ½)        z_n = [s_n ; v_n]

    as in Tidemann & Öztürk 2008 and Jaeger's toolbox: no bias, no feedback from the output;
    the noise is present while executing, too, where it stabilises. All recurrences are one
    product with a block-diagonal sparse matrix; of small reservoirs [W W_in] is one full matrix.

    Arrays begin with `batch_shape`, () for one run and (R,) for a batch of R. Each run's
    reservoirs are drawn from that run's stream, and do not depend on the others.

    Attributes:
        features: Length of z, nodes + inputs.
    """

    def __init__(
        self,
        batch_shape: tuple[int, ...],
        count: int,
        inputs: int,
        nodes: int,
        *,
        radius: float,
        noise: float,
        streams: Streams,
    ) -> None:
        """Draw the reservoirs' weights.

        Args:
            batch_shape: Shape of the runs.
            count: Number of reservoirs of a run, M.
            inputs: Size of the input v, D.
            nodes: Neurons of a reservoir, N.
            radius: Spectral radius of every W.
            noise: Noise level ν.
            streams: Source of the weights of each run.
        """
        self.features = nodes + inputs
        self._noise, self._radius = noise, radius
        self._group = count
        self._input_weights: Single = np.empty((*batch_shape, 0, nodes, inputs), PRECISION)
        self._recurrence: Any = None  # W of all reservoirs, one sparse matrix
        self.extend(streams)
        self.reset(streams)

    def extend(self, streams: Streams) -> None:
        """Add another group of M reservoirs to each run, from the next reset.

        Args:
            streams: Source of the weights of each run.
        """
        *batch_shape, present, nodes, inputs = self._input_weights.shape
        count = self._group
        drawn, blocks = [], []
        for stream in streams:
            drawn.append(stream.uniform(-1.0, 1.0, (count, nodes, inputs)))
            blocks += [random_recurrence(nodes, self._radius, stream) for _ in range(count)]
        added = np.reshape(drawn, (*batch_shape, count, nodes, inputs)).astype(PRECISION)
        recurrence = block_diagonal(blocks).astype(PRECISION)
        self._input_weights = np.concatenate([self._input_weights, added], axis=-3)
        if not present:
            self._recurrence = recurrence
            self._full = self._full_weights()
            return
        # Neurons are ordered by run, then by reservoir: those of the group go behind each run's.
        before = np.arange(self._recurrence.shape[0]).reshape(-1, present * nodes)
        behind = before.size + np.arange(recurrence.shape[0]).reshape(-1, count * nodes)
        order = np.concatenate([before, behind], axis=1).ravel()
        joined = sp.block_diag([self._recurrence, recurrence], format="csr")
        self._recurrence = sp.csr_array(joined)[order][:, order]
        self._full = self._full_weights()

    def _full_weights(self) -> Single | None:
        """Return [W W_in], shape (..., M, N, N + D), of small reservoirs; None of larger ones."""
        shape, nodes = self._input_weights.shape[:-2], self._input_weights.shape[-2]
        if nodes > _FULL:
            return None
        rows = self._recurrence.tocoo()
        reservoir, row = np.divmod(rows.coords[0], nodes)
        recurrence = np.zeros((math.prod(shape), nodes, nodes), PRECISION)
        # Weights in the same column are added.
        np.add.at(recurrence, (reservoir, row, rows.coords[1] % nodes), rows.data)
        recurrence = recurrence.reshape(*shape, nodes, nodes)
        return np.concatenate([recurrence, self._input_weights], axis=-1)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the features, (..., M, N + D)."""
        return (*self._input_weights.shape[:-2], self.features)

    def reset(self, *groups: Streams) -> None:
        """Set all states to 0; noise is drawn from these streams, one for each group and run."""
        self._state: Single = np.zeros(self._input_weights.shape[:-1], PRECISION)
        self._groups = groups
        self._ahead: Iterator[Single] = iter(())  # noise of the next steps

    def select_runs(self, runs: NDArray[np.intp]) -> None:
        """Continue with some runs only, (R',) of R, from the next reset."""
        count, nodes = self._input_weights.shape[1:3]
        own = (count * nodes * runs[:, None] + np.arange(count * nodes)).ravel()
        self._input_weights = self._input_weights[runs]
        self._recurrence = self._recurrence[own][:, own]
        self._full = None if self._full is None else self._full[runs]

    def of_run(self, index: tuple[int, ...]) -> ReservoirBank:
        """Return one run's reservoirs with separate states, at rest from the next reset."""
        part = copy.copy(self)
        part._input_weights = self._input_weights[index]
        size = part._input_weights.shape[0] * part._input_weights.shape[1]
        own = slice(index[0] * size, (index[0] + 1) * size) if index else slice(None)
        part._recurrence = self._recurrence[own][:, own]
        part._full = None if self._full is None else self._full[index]
        return part

    def step(self, inputs: Array, features: Single | None = None) -> Single:
        """Update the states with an input.

        Args:
            inputs: Input v, shape (..., D) for all reservoirs of a run alike or (..., M, D).
            features: Array for the features; a new one if not given.

        Returns:
            Features z, shape (..., M, N + D).
        """
        state = self._state
        if inputs.ndim < state.ndim:
            inputs = inputs[..., None, :]
        if features is None:
            features = np.empty(self.shape, PRECISION)
        own, driven = features[..., : state.shape[-1]], features[..., state.shape[-1] :]
        driven[...] = inputs
        if self._full is None:
            driving = inputs.astype(PRECISION)
            sums = (self._input_weights @ driving[..., None])[..., 0]  # (..., M, N)
            sums += (self._recurrence @ state.ravel()).reshape(state.shape)
        else:
            own[...] = state  # [s_{n-1} ; v_n]
            sums = (self._full @ features[..., None])[..., 0]
        np.tanh(sums, out=sums)
        sums += self._next_noise()
        own[...] = self._state = sums
        return features

    def _next_noise(self) -> Single:
        noise: Single | None = next(self._ahead, None)
        if noise is None:
            shape = self._state.shape
            each = (_DRAWN_AHEAD, self._group, shape[-1])
            by_group = [
                np.stack([stream.random(each) for stream in streams], axis=1)
                for streams in self._groups
            ]
            drawn = np.concatenate(by_group, axis=2)
            drawn -= 0.5
            drawn *= self._noise
            self._ahead = iter(drawn.astype(PRECISION).reshape(_DRAWN_AHEAD, *shape))
            return next(self._ahead)
        return noise


_BLOCK = (
    4096  # steps of one sum, so that sums are equal for kept and for replayed features (choice)
)


class FeatureReplay:
    """Features z of an episode, shape (T, M, F), computed by the reservoirs once more.

    As noise depends on seed and episode alone, they are the same to the bit.

    Attributes:
        shape: (T, M, F).
    """

    def __init__(
        self,
        bank: ReservoirBank,
        noise: Callable[[], Sequence[np.random.Generator]],
        inputs: Features,
    ) -> None:
        """Keep the inputs and the source of the noise.

        Args:
            bank: Reservoirs of one run, with states that nothing else uses.
            noise: Returns the sources of the episode's noise, at its beginning, one for each group.
            inputs: Inputs v, shape (T, D) or (T, M, D).
        """
        self._bank, self._noise, self._inputs = bank, noise, inputs
        self.shape = (len(inputs), *bank.shape)

    def blocks(self) -> Iterator[tuple[slice, Features]]:
        """Yield steps and their features, (B, M, F), which the next block overwrites."""
        self._bank.reset(*([source] for source in self._noise()))
        steps = len(self._inputs)
        block = np.empty((min(_BLOCK, steps), *self._bank.shape), PRECISION)
        for start in range(0, steps, _BLOCK):
            rows = slice(start, min(start + _BLOCK, steps))
            for row, driving in enumerate(self._inputs[rows]):
                self._bank.step(driving, block[row])
            yield rows, block[: rows.stop - rows.start]


def blocks(features: Features | FeatureReplay) -> Iterator[tuple[slice, Features]]:
    """Yield steps of an episode and their features, shape (B, M, F), block by block."""
    if isinstance(features, FeatureReplay):
        yield from features.blocks()
        return
    for start in range(0, len(features), _BLOCK):
        rows = slice(start, start + _BLOCK)
        yield rows, features[rows]
