"""Batches of agents beside the same agents alone."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mpma_mj import load, make_vec
from mpma_mj.training.rollout import record_epoch

__all__ = ["IDEAL", "assert_batch_equals_alone"]

IDEAL: dict[str, Any] = {"arms": "kinematic", "repeats": 1}


def assert_batch_equals_alone(make: Callable[[Any, Any], Any], epochs: int) -> None:
    """Check that the second run of a batch is that of its agent alone, to the bit.

    Args:
        make: Makes agents for environments and seeds, or an agent for one of each.
        epochs: Epochs before all but that run are left out.
    """
    envs, env = make_vec(2, "ymca", **IDEAL), load("ymca", seed=1, **IDEAL)
    together, alone = make(envs, [3, 5]), make(env, 5)
    for epoch in range(epochs):
        trace = record_epoch(envs, together, epoch).of_run(1).to_arrays()
        for name, signal in record_epoch(env, alone, epoch).to_arrays().items():
            np.testing.assert_array_equal(trace[name], signal, err_msg=f"{name} {epoch}")
        together.learn()
        alone.learn()
    for name, value in alone.state_dict().items():
        np.testing.assert_array_equal(together.state_dict()[name][1], value)
    together.select_runs(np.array([1]))
    selected = record_epoch(make_vec(1, "ymca", seed=1, **IDEAL), together, epochs).of_run(0)
    np.testing.assert_array_equal(selected.action, record_epoch(env, alone, epochs).action)
