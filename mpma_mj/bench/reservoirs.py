"""The networks of an agent in ReservoirPy (Trouvain et al. 2020)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from mpma_mj.bench.timing import Case

__all__ = ["reservoirs"]

Array = NDArray[np.float64]

_CONNECTIONS = 10  # of a neuron, as in our own


def reservoirs(
    modules: int, nodes: int, radius: float, sizes: Mapping[str, tuple[int, int]], steps: int
) -> Case:
    """Return one control step after another of three networks a module.

    They do less than ours: without noise, gates and feedback controller, and nothing is remembered
    to be learned from. Readouts hear reservoir and input, as ours do. Networks are stepped one by
    one, since a step leads to the next input; this is faster than as one `Model`.

    Args:
        modules: Number of modules.
        nodes: Neurons of each reservoir.
        radius: Spectral radius.
        sizes: Inputs and outputs of each kind of network, by name.
        steps: How many control steps.

    Returns:
        Its unit of work is a control step.
    """
    rng = np.random.default_rng(0)
    networks = [
        (_network(nodes, radius, inputs, outputs, rng), rng.uniform(-1.0, 1.0, (steps, inputs)))
        for inputs, outputs in sizes.values()
        for _ in range(modules)
    ]

    def run() -> int:
        for step in range(steps):
            for network, inputs in networks:
                network(inputs[step])
        return steps

    return Case(run)


def _network(
    nodes: int, radius: float, inputs: int, outputs: int, rng: np.random.Generator
) -> Callable[[Array], Array]:
    """Return what maps an input, (D,), to the output, (K,)."""
    from reservoirpy.mat_gen import uniform
    from reservoirpy.nodes import Reservoir, Ridge

    reservoir = Reservoir(
        nodes,
        sr=radius,
        rc_connectivity=min(1.0, _CONNECTIONS / nodes),
        input_connectivity=1.0,
        W=uniform,
        Win=uniform,
        seed=rng.spawn(1)[0],
    )
    readout = Ridge(Wout=rng.uniform(-1.0, 1.0, (nodes + inputs, outputs)), bias=np.zeros(outputs))

    def step(x: Array) -> Array:
        return np.asarray(readout.step(np.concatenate([reservoir.step(x), x])))

    return step
