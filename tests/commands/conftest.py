"""Fixtures of tests of commands: copies of a finished run, a robot and its log."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files
from tests.sysid.conftest import factors as factors
from tests.sysid.conftest import log as log

Reconfigured = Callable[..., Path]


@pytest.fixture
def run(small_run: Path, tmp_path: Path) -> Path:
    """Return a copy of a finished run of three modules."""
    return shutil.copytree(small_run, tmp_path / "run")


@pytest.fixture
def reconfigured(small_run: Path, tmp_path: Path) -> Reconfigured:
    """Return a function that copies the run, as if it had been trained with other options."""

    def copy(**changed: Any) -> Path:
        folder = RunFolder(shutil.copytree(small_run, tmp_path / "other"))
        before = folder.read_config()
        config = before.replace(**changed)
        for name in ("best", "latest"):
            state, meta = folder.read_checkpoint(name, before)
            meta |= {"config": config.to_json()}
            folder.write_checkpoint(name, config, state, meta)
        content = data_files.read_json(folder.path / "config.json")
        content |= {"config": config.to_json()}
        data_files.write_json(folder.path / "config.json", content)
        return folder.path

    return copy
