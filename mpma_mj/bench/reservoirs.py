"""The networks of an agent in ReservoirPy (Trouvain et al. 2020)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mpma_mj.bench.timing import Case

__all__ = ["reservoirs"]

Array = NDArray[np.float64]
Network: TypeAlias = Callable[[Array], Array]  # input, (D,), to output, (K,)

_CONNECTIONS = 10  # of a neuron, as in our own


def reservoirs(
    modules: int,
    nodes: int,
    radius: float,
    sizes: Sequence[tuple[int, int]],
    steps: int,
    *,
    joined: bool,
) -> Case:
    """Return one control step after another of three networks a module.

    They do less than ours: without noise, gates and feedback controller, and nothing is remembered
    to be learned from. Readouts hear reservoir and input, as ours do. Each is stepped once a
    control step, since a step leads to the next input.

    Args:
        modules: Number of modules.
        nodes: Neurons of each reservoir.
        radius: Spectral radius.
        sizes: Inputs and outputs of each of a module's networks.
        steps: How many control steps.
        joined: Whether reservoir and readout are joined to a `Model`, as ReservoirPy's users do; if
            not its nodes are stepped one by one, which costs less.

    Returns:
        Its unit of work is a control step.
    """
    rng = np.random.default_rng(0)
    make = _model if joined else _nodes
    networks = [
        (make(nodes, radius, inputs, outputs, rng), rng.uniform(-1.0, 1.0, (steps, inputs)))
        for inputs, outputs in sizes
        for _ in range(modules)
    ]

    def run() -> int:
        for step in range(steps):
            for network, inputs in networks:
                network(inputs[step])
        return steps

    return Case(run)


def _model(nodes: int, radius: float, inputs: int, outputs: int, rng: Generator) -> Network:
    """Return the step of a network as a `Model`."""
    from reservoirpy.nodes import Input

    source, readout = Input(), _readout(nodes + inputs, outputs, rng)
    model = (source >> _reservoir(nodes, radius, rng) >> readout) & (source >> readout)
    return model.step


def _nodes(nodes: int, radius: float, inputs: int, outputs: int, rng: Generator) -> Network:
    """Return the step of a network whose nodes are stepped one by one."""
    reservoir = _reservoir(nodes, radius, rng)
    readout = _readout(nodes + inputs, outputs, rng)
    return lambda x: readout.step(np.concatenate([reservoir.step(x), x]))


def _reservoir(nodes: int, radius: float, rng: Generator) -> Any:
    from reservoirpy.mat_gen import uniform
    from reservoirpy.nodes import Reservoir

    return Reservoir(
        nodes,
        sr=radius,
        rc_connectivity=min(1.0, _CONNECTIONS / nodes),
        input_connectivity=1.0,
        W=uniform,
        Win=uniform,
        seed=rng.spawn(1)[0],
    )


def _readout(features: int, outputs: int, rng: Generator) -> Any:
    from reservoirpy.nodes import Ridge

    return Ridge(Wout=rng.uniform(-1.0, 1.0, (features, outputs)), bias=np.zeros(outputs))
