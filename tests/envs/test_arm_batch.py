"""Batches of arms in forked processes."""

import gc
import multiprocessing
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from mpma_mj.envs.make_vec import make_vec
from mpma_mj.envs.vector_env import VectorImitationEnv


@contextmanager
def many(num_envs: int, **options: Any) -> Iterator[VectorImitationEnv]:
    envs = make_vec(num_envs, **{"repeats": 1, **options})
    yield envs
    envs.close()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.parametrize("use", ["step and close", "close", "forget", "leave"])
def test_a_forked_process_ends_after_any_use_of_its_parents_environments(use: str) -> None:
    envs = make_vec(4, repeats=1)
    envs.reset()

    def work() -> None:
        nonlocal envs
        if use == "step and close":
            envs.step(np.ones((4, 8)))
        if "close" in use:
            envs.close()
        if use == "forget":
            envs = make_vec(4, repeats=1)
            gc.collect()

    child = multiprocessing.get_context("fork").Process(target=work)
    child.start()
    child.join(timeout=60)
    assert child.exitcode == 0
    envs.step(np.ones((4, 8)))
    envs.close()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_has_threads_of_its_own() -> None:
    with many(4) as envs:
        envs.reset()
        expected = envs.step(np.ones((4, 8)))[0]["posture"]
        envs.reset(seed=0)
        results: Any = multiprocessing.get_context("fork").Queue()
        step = lambda: results.put(envs.step(np.ones((4, 8)))[0]["posture"])  # noqa: E731
        child = multiprocessing.get_context("fork").Process(target=step)
        child.start()
        np.testing.assert_array_equal(results.get(timeout=60), expected)
        child.join(timeout=60)
        assert child.exitcode == 0
        np.testing.assert_array_equal(envs.step(np.ones((4, 8)))[0]["posture"], expected)
