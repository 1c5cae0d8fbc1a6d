"""Sparse recurrent matrices of a given spectral radius."""

from __future__ import annotations

import functools

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse import linalg

__all__ = ["block_diagonal", "random_recurrence", "spectral_radius"]

Array = NDArray[np.float64]

# Inputs of each neuron from others (choice): enough to mix, few enough to be fast.
_CONNECTIONS = 10

# Up to this number of neurons LAPACK computes all eigenvalues faster than ARPACK the largest.
_DENSE = 60
# Eigenvalues that ARPACK computes, and its vectors. The largest are close in modulus: with fewer,
# it may return the second, a hundredth smaller. With these the error is below 1e-5.
_FOLLOWED, _VECTORS, _TOLERANCE = 6, 40, 1e-4


def random_recurrence(nodes: int, radius: float, rng: np.random.Generator) -> sp.csr_array:
    """Draw a sparse recurrent matrix of a given spectral radius.

    Args:
        nodes: Number of neurons, N.
        radius: Spectral radius, 0 or more.
        rng: Source of columns and weights.

    Returns:
        W, shape (N, N), with `_CONNECTIONS` weights a row, or N where there are fewer neurons;
        weights in the same column are added.
    """
    degree = min(_CONNECTIONS, nodes)
    columns = rng.integers(0, nodes, (nodes, degree), dtype=np.int32)
    weights = rng.uniform(-1.0, 1.0, (nodes, degree))
    starts = np.arange(0, nodes * degree + 1, degree, dtype=np.int32)
    matrix = sp.csr_array((weights.ravel(), columns.ravel(), starts), shape=(nodes, nodes))
    return matrix * (radius / spectral_radius(matrix))


def spectral_radius(matrix: sp.csr_array) -> float:
    """Return the largest modulus of a square matrix's eigenvalues, remembered for some time."""
    return _radius(matrix.data.tobytes(), matrix.indices.tobytes(), matrix.indptr.tobytes())


# As many as three networks of four modules have in twenty runs: agents of the same seeds are often
# made again. Matrices are compared by content, so that nothing depends on what was made before.
@functools.lru_cache(maxsize=256)
def _radius(weights: bytes, columns: bytes, starts: bytes) -> float:
    """Compute the spectral radius of a square matrix from the contents of its arrays."""
    rows = np.frombuffer(starts, np.int32)
    nodes = len(rows) - 1
    contents = np.frombuffer(weights), np.frombuffer(columns, np.int32), rows
    matrix = sp.csr_array(contents, shape=(nodes, nodes))
    if nodes <= _DENSE:
        return float(np.abs(np.linalg.eigvals(matrix.toarray())).max())
    largest = linalg.eigs(
        matrix,
        k=_FOLLOWED,
        ncv=_VECTORS,
        tol=_TOLERANCE,
        v0=np.ones(nodes),  # the default is random
        return_eigenvectors=False,
    )
    return float(np.abs(largest).max())


def block_diagonal(blocks: list[sp.csr_array]) -> sp.csr_array:
    """Join square matrices, all with the same number of weights in a row, along the diagonal."""
    nodes = blocks[0].shape[0]
    size = len(blocks) * nodes
    columns = np.concatenate([block.indices + i * nodes for i, block in enumerate(blocks)])
    weights = np.concatenate([block.data for block in blocks])
    starts = np.linspace(0, len(weights), size + 1).astype(np.int32)
    return sp.csr_array((weights, columns.astype(np.int32), starts), shape=(size, size))
