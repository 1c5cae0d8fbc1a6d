"""What tests of trials need: a tiny run."""

from pathlib import Path

import pytest

from mpma_mj.cli import main
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.run_folder import RunFolder

TINY = "--nodes 10 --modules 2 --repeats 1 --seed 4 --no-video"


@pytest.fixture(scope="session")
def tiny_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of tiny networks, made by the command line."""
    folder = tmp_path_factory.mktemp("runs") / "tiny"
    assert main(f"imitate ymca {TINY} --epochs 8 --out {folder}".split()) == 0
    return folder


@pytest.fixture(scope="session")
def tiny(tiny_run: Path) -> TrainedAgents:
    """Return its agent."""
    return TrainedAgents.of_run(RunFolder(tiny_run))
