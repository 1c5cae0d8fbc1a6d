"""Folder of a run: config, checkpoints, trace, metrics and results."""

from __future__ import annotations

import contextlib
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.base import MODULE_SIGNALS
from mpma_mj.errors import (
    BadOptionError,
    CheckpointError,
    MotionFileError,
    RunFolderError,
    one_line,
)
from mpma_mj.motions import Motion
from mpma_mj.motions.motion import load_motion, save_motion
from mpma_mj.trace import SIGNALS, Trace
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.config_json import OutsideConfig
from mpma_mj.utils import atomic_files, data_files
from mpma_mj.utils.folder_lock import is_empty, locked

__all__ = ["RunFolder", "open_runs"]

Array = NDArray[np.float64]

_ANALYSES = ("modules", "lesion", "free_running")

# Contents that overwriting removes; other files belong to the user. config.json, which identifies
# a run, comes last, so that an interrupted removal can be repeated.
_CONTENTS = (
    "metrics.csv",
    "summary.json",
    *(f"{analysis}.json" for analysis in _ANALYSES),
    "trace.npz",
    "checkpoint",
    "figures",
    "evaluations",
    "dance.mp4",
    "config.json",
)

_ANOTHER_FOLDER = "choose another folder with {out}"


@dataclass(frozen=True)
class RunFolder:
    """Paths and contents of a run.

    Attributes:
        path: The folder.
        trusted: Paths of classes from outside the package, such as my_agents.py:MyAgent, that the
            user has named; only these may be imported for the run.
    """

    path: Path
    trusted: tuple[str, ...] = ()

    @property
    def video(self) -> Path:
        """Video of the best epoch."""
        return self.path / "dance.mp4"

    @property
    def evaluations(self) -> Path:
        """Folder with a folder for each evaluation."""
        return self.path / "evaluations"

    @property
    def figures(self) -> Path:
        """Folder of the figures."""
        return self.path / "figures"

    @property
    def can_go_on(self) -> bool:
        """Whether a checkpoint exists from which training can be resumed."""
        return (self.path / "checkpoint" / "latest.npz").exists()

    def results_of(self, analysis: str) -> Path:
        """Return the path of an analysis' results: modules, lesion or free_running."""
        return self.path / f"{analysis}.json"

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the run, so that no other command changes it.

        Raises:
            RunFolderError: There is no run, another command changes it, or it is not writable.
            CheckpointError: The config is damaged or of another version.
        """
        self.read_config()
        with locked(self.path):
            yield

    def create(self, config: RunConfig, motion: Motion, *, overwrite: bool) -> None:
        """Create the folder of a new run.

        Args:
            config: Config of the run.
            motion: The motion, saved so that the run can be resumed without the recording.
            overwrite: Whether to replace an earlier run in the folder.

        Raises:
            RunFolderError: The folder holds a run that must not be replaced, holds other files, or
                cannot be written.
        """
        content = {
            "format": data_files.FORMAT,
            "config": config.to_json(),
            "versions": versions(),
        }
        try:
            json.dumps(content)  # before an earlier run is removed
        except (TypeError, ValueError) as error:
            expected = f"options that JSON can hold ({one_line(error)})"
            raise BadOptionError(option="agent", value=config.agent, expected=expected) from None
        if self.path.exists():
            self._remove(overwrite)
        data_files.write_json(self.path / "config.json", content)
        save_motion(self.path / "checkpoint" / "motion.npz", motion)

    def _remove(self, overwrite: bool) -> None:
        if not self.path.is_dir():
            raise RunFolderError(f"{self.path}: is a file", remedy=_ANOTHER_FOLDER)
        if is_empty(self.path):
            return
        try:
            self.read_config()
        except (RunFolderError, CheckpointError):
            raise RunFolderError(
                f"{self.path}: is not empty and not a run of this version", remedy=_ANOTHER_FOLDER
            ) from None
        if not overwrite:
            raise RunFolderError(
                f"{self.path}: already contains a run",
                remedy="{overwrite} replaces it, {resume} continues it",
            )
        try:
            for name in _CONTENTS:
                content = self.path / name
                shutil.rmtree(content) if content.is_dir() else content.unlink(missing_ok=True)
        except OSError as error:
            raise RunFolderError(f"{self.path}: cannot be replaced ({error.strerror})") from None

    def read_config(self) -> RunConfig:
        """Read the config.

        Raises:
            RunFolderError: There is no run.
            CheckpointError: The config is damaged or of another version.
        """
        path = self.path / "config.json"
        try:
            content = data_files.read_json(path)
            return RunConfig.from_json(content["config"], self.trusted)
        except OSError:
            raise RunFolderError(
                f"{self.path}: is not a run (no readable config.json)",
                remedy="expected a folder that mpma imitate wrote, such as runs/ymca",
            ) from None
        except (AttributeError, ValueError, KeyError, TypeError) as error:
            if isinstance(error, BadOptionError) and error.option in ("agent", "rule"):
                raise  # a class that the user has named
            raise CheckpointError(
                f"{path}: damaged, or not of a run", remedy="train again"
            ) from None

    def read_motion(self) -> Motion:
        """Read the motion of the run.

        Raises:
            CheckpointError: The file is missing or damaged.
        """
        path = self.path / "checkpoint" / "motion.npz"
        try:
            motion = load_motion(path)
        except FileNotFoundError:
            raise CheckpointError(f"{path}: missing", remedy=data_files.TRAIN_AGAIN) from None
        except MotionFileError:
            motion = None
        if motion is None:
            raise CheckpointError(f"{path}: damaged", remedy=data_files.TRAIN_AGAIN)
        return motion

    def forget_epoch(self) -> None:
        """Remove results of an epoch that is no longer the best one."""
        results = (self.results_of(analysis) for analysis in _ANALYSES)
        pictures = (self.figures / f"{analysis}.png" for analysis in _ANALYSES)
        for path in (self.video, *results, *pictures):
            path.unlink(missing_ok=True)
        if self.evaluations.exists():
            shutil.rmtree(self.evaluations)

    def write_checkpoint(
        self, name: str, config: RunConfig, state: Mapping[str, Array], meta: dict[str, Any]
    ) -> None:
        """Write the state of an agent, with further entries of the header as in JSON.

        The file is `checkpoint/best.npz` or `latest.npz`; the config is compared on reading.
        """
        path = self.path / "checkpoint" / f"{name}.npz"
        data_files.write_arrays(path, "checkpoint", state, {"config": config.to_json()} | meta)

    def read_checkpoint(
        self, name: str, config: RunConfig
    ) -> tuple[dict[str, Array], dict[str, Any]]:
        """Read a checkpoint that `write_checkpoint` wrote.

        Returns:
            State of the agent, arrays by name; and the header of the file.

        Raises:
            CheckpointError: The file is missing or damaged, or belongs to a run with another
                config.
        """
        path = self.path / "checkpoint" / f"{name}.npz"
        state, meta = data_files.read_arrays(path, "checkpoint")
        if meta.get("config") != data_files.as_json(config.to_json()):
            raise CheckpointError(
                f"{path}: belongs to a run with another config", remedy="train again"
            )
        return state, meta

    def read_best(self, config: RunConfig) -> tuple[dict[str, Array], int]:
        """Read the state of the agent in the best epoch, and the number of that epoch, from 1.

        Raises:
            CheckpointError: As of `read_checkpoint`, or the number is missing.
        """
        state, meta = self.read_checkpoint("best", config)
        try:
            return state, int(meta["row"]["epoch"])
        except (KeyError, TypeError, ValueError):
            raise CheckpointError(
                f"{self.path}: the checkpoint does not contain the number of its epoch",
                remedy="train again",
            ) from None

    def write_trace(self, trace: Trace, epoch: int) -> None:
        """Write the trace of the best epoch."""
        arrays = trace.to_arrays()
        data_files.write_arrays(self.path / "trace.npz", "trace", arrays, {"epoch": epoch})

    def read_trace(self) -> Trace:
        """Read the trace of the best epoch.

        Raises:
            CheckpointError: The file is missing or damaged, or lacks a signal.
        """
        path = self.path / "trace.npz"
        arrays, _ = data_files.read_arrays(path, "trace")
        has_modules = any(name in arrays for name in MODULE_SIGNALS)
        expected = (*SIGNALS, *MODULE_SIGNALS) if has_modules else SIGNALS
        missing = [name for name in expected if name not in arrays]
        if missing:
            raise CheckpointError(
                f"{path}: lacks {', '.join(missing)}", remedy=data_files.TRAIN_AGAIN
            )
        return Trace.from_arrays(arrays)

    def write_metrics(self, rows: list[dict[str, float]]) -> None:
        """Write the metrics of all epochs, a row for each."""
        atomic_files.write_text(self.path / "metrics.csv", data_files.csv_text(rows))

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write the summary of the run."""
        data_files.write_json(self.path / "summary.json", summary)


def open_runs(
    paths: Iterable[Path], *, agent: str | None = None, rule: str | None = None
) -> list[RunFolder]:
    """Return the folders of trained runs.

    Args:
        paths: The folders.
        agent: Path of the class of an agent from outside the package, which may be imported.
        rule: Path of the class of a learning rule, likewise.

    Raises:
        RunFolderError: There is no run.
        CheckpointError: A config is damaged or of another version.
        BadOptionError: A class is named with which none of the runs was trained.
    """
    trusted = {"agent": agent, "rule": rule}
    folders = [RunFolder(path, tuple(filter(None, trusted.values()))) for path in paths]
    configs = [RunFolder(folder.path).read_config().agent for folder in folders]
    outside = [config.outside for config in configs if isinstance(config, OutsideConfig)]
    for option, path in trusted.items():
        if path is not None and all(classes.get(option) != path for classes in outside):
            expected = "the path of a class from outside with which a run was trained"
            raise BadOptionError(
                option=option, value=path, expected=expected, remedy=f"leave {{{option}}} out"
            )
    return folders
