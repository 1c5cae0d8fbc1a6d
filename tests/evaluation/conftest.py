"""Fixtures of tests of evaluations: the agent of a small run."""

from pathlib import Path

import pytest

from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.run_folder import RunFolder


@pytest.fixture(scope="session")
def small(small_run: Path) -> TrainedAgents:
    """Return the agent of a finished run of small networks."""
    return TrainedAgents.of_run(RunFolder(small_run))
