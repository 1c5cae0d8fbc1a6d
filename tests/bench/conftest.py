"""Benchmarks that are made small: what they time is no matter in tests."""

from __future__ import annotations

import pytest

from mpma_mj.bench import agent, environment, peers, programs
from mpma_mj.training.config import RunConfig


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make networks, companies and rounds as small as can be."""
    for module in (agent, peers):
        monkeypatch.setattr(module, "_CONFIG", RunConfig.of(modules=2, nodes=5, repeats=1))
        monkeypatch.setattr(module, "_RUNS", 2)
    for module in (agent, environment, peers, programs):
        monkeypatch.setattr(module, "_ROUNDS", 1)
    monkeypatch.setattr(environment, "_STARTS", 1)
    monkeypatch.setattr(environment, "_MEMBERS", 2)
    monkeypatch.setattr(peers, "_STEPS", 5)
