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


def write_config(run: Path, config: dict[str, Any]) -> None:
    """Write another config into all files of a run."""
    for path in run.rglob("*.npz"):
        kind = {"trace": "trace", "motion": "motion"}.get(path.stem, "checkpoint")
        arrays, meta = data_files.read_arrays(path, kind)
        data_files.write_arrays(path, kind, arrays, meta | {"config": config})
    content = data_files.read_json(run / "config.json")
    data_files.write_json(run / "config.json", content | {"config": config})


@pytest.fixture
def reconfigured(small_run: Path, tmp_path: Path) -> Reconfigured:
    """Return a function that copies the run, as if it had been trained with other options."""

    def copy(**changed: Any) -> Path:
        folder = RunFolder(shutil.copytree(small_run, tmp_path / "other"))
        write_config(folder.path, folder.read_config().replace(**changed).to_json())
        return folder.path

    return copy
