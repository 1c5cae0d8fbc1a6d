"""Banks of echo state reservoirs that step together."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

__all__ = ["ReservoirBank", "random_recurrence"]

Array = NDArray[np.float64]

# Each neuron hears this many others (choice): enough to mix, few enough to be fast.
_CONNECTIONS = 10


class ReservoirBank:
    """A number of independent reservoirs in stacked arrays.

        s_n = tanh(W s_{n-1} + W_in v_n) + ν · U(-½, ½)        z_n = [s_n ; v_n]

    as in Tidemann & Öztürk 2008 and Jaeger's toolbox: no bias, no feedback from the output;
    the noise stays on while executing, where it stabilises. All recurrences are one product
    with a block-diagonal sparse matrix.

    Attributes:
        features: Length of z, nodes + inputs.
    """

    def __init__(
        self,
        count: int,
        inputs: int,
        nodes: int,
        *,
        radius: float,
        noise: float,
        rng: np.random.Generator,
    ) -> None:
        """Draw the reservoirs' weights.

        Args:
            count: Number of reservoirs, M.
            inputs: Size of the input v, D.
            nodes: Neurons of a reservoir, N.
            radius: Spectral radius of every W.
            noise: Noise level ν.
            rng: Source of the weights.
        """
        self.features = nodes + inputs
        self._noise = noise
        self._input_weights = rng.uniform(-1.0, 1.0, (count, nodes, inputs))
        self._recurrence: sp.csr_array = sp.block_diag(
            [random_recurrence(nodes, radius, rng) for _ in range(count)], format="csr"
        )
        self._state = np.zeros((count, nodes))

    def reset(self) -> None:
        """Set all states to 0."""
        self._state = np.zeros_like(self._state)

    def step(self, inputs: Array, rng: np.random.Generator) -> Array:
        """Update the states with an input.

        Args:
            inputs: Input v, shape (D,) for all reservoirs alike or (M, D).
            rng: Source of the noise.

        Returns:
            Features z, shape (M, N + D), a new array.
        """
        count, nodes = self._state.shape
        recurrent = (self._recurrence @ self._state.ravel()).reshape(count, nodes)
        driven = (self._input_weights @ inputs[..., None])[..., 0]  # (M, N)
        noise = self._noise * (rng.random((count, nodes)) - 0.5)
        self._state = np.tanh(recurrent + driven) + noise
        features = np.empty((count, self.features))
        features[:, :nodes] = self._state
        features[:, nodes:] = inputs
        return features


def random_recurrence(nodes: int, radius: float, rng: np.random.Generator) -> sp.csr_array:
    """Draw a sparse recurrent matrix of a given spectral radius.

    Args:
        nodes: Number of neurons, N.
        radius: Spectral radius, 0 or more.
        rng: Source of places and weights.

    Returns:
        W, shape (N, N), with `_CONNECTIONS` weights a row (all of them where N is smaller).
    """
    degree = min(_CONNECTIONS, nodes)
    columns = np.argpartition(rng.random((nodes, nodes)), degree - 1, axis=1)[:, :degree]
    weights = rng.uniform(-1.0, 1.0, (nodes, degree))
    rows = np.repeat(np.arange(nodes), degree)
    matrix = sp.csr_array((weights.ravel(), (rows, columns.ravel())), shape=(nodes, nodes))
    return matrix * (radius / np.max(np.abs(np.linalg.eigvals(matrix.toarray()))))
