"""The folder of a run: what is in it, how it is made, how it is read again."""

from __future__ import annotations

import contextlib
import json
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj._version import __version__
from mpma_mj.agents.signals import MODULE_SIGNALS
from mpma_mj.errors import CheckpointError, MotionFileError, RunFolderError
from mpma_mj.motions import Motion, motion_file
from mpma_mj.trace import SIGNALS, Trace
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.utils import atomic_files
from mpma_mj.utils.folder_lock import is_empty, locked

__all__ = ["RunFolder"]

Array = NDArray[np.float64]

# What `--overwrite` removes; anything else in the folder is the user's own. What makes it a run
# comes last, so that a removal that was cut short can be done again.
_CONTENTS = (
    "metrics.csv",
    "summary.json",
    "capture.json",
    "attractor.json",
    "lesion.json",
    "trace.npz",
    "checkpoint",
    "figures",
    "stress",
    "dance.mp4",
    "config.json",
)


@dataclass(frozen=True)
class RunFolder:
    """Paths and contents of a run.

    Attributes:
        path: The folder.
        trusted: Paths of classes from outside the package, such as my_agents.py:MyAgent, that the
            user has named, and that a run may therefore import.
    """

    path: Path
    trusted: tuple[str, ...] = ()

    @property
    def video(self) -> Path:
        """Where the video is."""
        return self.path / "dance.mp4"

    @property
    def captured(self) -> Path:
        """Where it is written which module captures what."""
        return self.path / "capture.json"

    @property
    def freed(self) -> Path:
        """Where it is written how the dance goes on without the demonstration."""
        return self.path / "attractor.json"

    @property
    def lesioned(self) -> Path:
        """Where it is written how it dances without each module."""
        return self.path / "lesion.json"

    @property
    def stress(self) -> Path:
        """Folder of folders of what is written of how it bears disturbances."""
        return self.path / "stress"

    @property
    def figures(self) -> Path:
        """Where the figures are."""
        return self.path / "figures"

    @property
    def can_go_on(self) -> bool:
        """Whether an epoch is saved with which training can go on."""
        return (self.path / "checkpoint" / "latest.npz").exists()

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the run, so that no other command changes it.

        Raises:
            RunFolderError: There is no run, another command changes it, or nobody can.
            CheckpointError: The settings are damaged or of another version.
        """
        self.read_config()
        with locked(self.path):
            yield

    def create(self, config: RunConfig, motion: Motion, *, overwrite: bool) -> None:
        """Make the folder for a new run.

        Args:
            config: Settings, written into it.
            motion: The movement, kept so that the run can go on without the recording.
            overwrite: Whether an earlier run in its place may be removed.

        Raises:
            RunFolderError: The folder exists, is no run, or cannot be written.
        """
        if self.path.exists():
            self._remove(overwrite)
        content = {
            "format": atomic_files.FORMAT,
            "config": config.to_json(),
            "versions": versions(),
        }
        atomic_files.write_json(self.path / "config.json", content)
        motion_file.write(self.path / "checkpoint" / "motion.npz", motion)

    @contextlib.contextmanager
    def created(self, config: RunConfig, motion: Motion, *, overwrite: bool) -> Iterator[None]:
        """Lock the folder, and make it as `create` does.

        Raises:
            RunFolderError: As of `create`, or another command writes into the folder.
        """
        with locked(self.path):
            self.create(config, motion, overwrite=overwrite)
            yield

    def _remove(self, overwrite: bool) -> None:
        if not self.path.is_dir():
            raise RunFolderError(f"{self.path}: is a file; choose another folder with --out")
        if is_empty(self.path):
            return
        try:
            self.read_config()
        except (RunFolderError, CheckpointError):
            raise RunFolderError(
                f"{self.path}: is not empty and not a run of this version; choose another folder"
                " with --out"
            ) from None
        if not overwrite:
            raise RunFolderError(
                f"{self.path}: a run is there; --overwrite replaces it, --resume continues it"
            )
        try:
            for name in _CONTENTS:
                content = self.path / name
                shutil.rmtree(content) if content.is_dir() else content.unlink(missing_ok=True)
        except OSError as error:
            raise RunFolderError(f"{self.path}: cannot be replaced ({error.strerror})") from None

    def read_config(self) -> RunConfig:
        """Read the settings.

        Raises:
            RunFolderError: There is no run.
            CheckpointError: The settings are damaged or of another version.
        """
        path = self.path / "config.json"
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            if content["format"] != atomic_files.FORMAT:
                writer = content.get("versions", {}).get("mpma-mj", "of another version")
                raise CheckpointError(
                    f"{path}: format {content['format']}, written by mpma-mj {writer}; this is"
                    f" {__version__}, which reads format {atomic_files.FORMAT}: train again"
                )
            return RunConfig.from_json(content["config"], self.trusted)
        except OSError:
            raise RunFolderError(f"{self.path}: no run there (no readable config.json)") from None
        except (ValueError, KeyError, TypeError):
            raise CheckpointError(f"{path}: damaged, or not of a run; train anew") from None

    def read_motion(self) -> Motion:
        """Read the movement that the run imitates."""
        path = self.path / "checkpoint" / "motion.npz"
        try:
            motion = motion_file.read(path)
        except FileNotFoundError:
            raise CheckpointError(f"{path}: missing; train anew with --overwrite") from None
        except MotionFileError:
            motion = None
        if motion is None:
            raise CheckpointError(f"{path}: damaged; train anew with --overwrite")
        return motion

    def forget_epoch(self) -> None:
        """Remove what was made of an epoch that is not kept any more."""
        names = ("capture", "attractor", "lesion")
        pictures = (self.figures / f"{name}.png" for name in names)
        for made in (self.video, self.captured, self.freed, self.lesioned, *pictures):
            made.unlink(missing_ok=True)
        if self.stress.exists():
            shutil.rmtree(self.stress)

    def write_checkpoint(
        self, name: str, config: RunConfig, state: Mapping[str, Array], meta: dict[str, Any]
    ) -> None:
        """Write an agent's state as `checkpoint/NAME.npz`."""
        path = self.path / "checkpoint" / f"{name}.npz"
        atomic_files.write_arrays(path, "checkpoint", state, {"config": config.to_json()} | meta)

    def read_checkpoint(
        self, name: str, config: RunConfig
    ) -> tuple[dict[str, Array], dict[str, Any]]:
        """Read what `write_checkpoint` wrote.

        Raises:
            CheckpointError: It is damaged, or belongs to a run with other settings.
        """
        path = self.path / "checkpoint" / f"{name}.npz"
        state, meta = atomic_files.read_arrays(path, "checkpoint")
        if meta.get("config") != json.loads(json.dumps(config.to_json())):
            raise CheckpointError(f"{path}: belongs to a run with other settings; train anew")
        return state, meta

    def read_best(self, config: RunConfig) -> tuple[dict[str, Array], int]:
        """Read what the agent had learned before the kept epoch, and that epoch's number, from 1.

        Raises:
            CheckpointError: As of `read_checkpoint`.
        """
        state, meta = self.read_checkpoint("best", config)
        try:
            return state, int(meta["row"]["epoch"])
        except (KeyError, TypeError, ValueError):
            raise CheckpointError(
                f"{self.path}: the checkpoint lacks the number of its epoch; train anew"
            ) from None

    def write_trace(self, trace: Trace, epoch: int) -> None:
        """Write the trace of the best epoch."""
        arrays = trace.to_arrays()
        atomic_files.write_arrays(self.path / "trace.npz", "trace", arrays, {"epoch": epoch})

    def read_trace(self) -> Trace:
        """Read the trace of the best epoch.

        Raises:
            CheckpointError: It is missing, damaged, or lacks a signal; names it.
        """
        path = self.path / "trace.npz"
        arrays, _ = atomic_files.read_arrays(path, "trace")
        has_modules = any(name in arrays for name in MODULE_SIGNALS)
        expected = (*SIGNALS, *MODULE_SIGNALS) if has_modules else SIGNALS
        lacking = [name for name in expected if name not in arrays]
        if lacking:
            raise CheckpointError(
                f"{path}: lacks {', '.join(lacking)}", remedy="train again with {overwrite}"
            )
        return Trace.from_arrays(arrays)

    def write_metrics(self, rows: list[dict[str, float]]) -> None:
        """Write a row for every epoch."""
        atomic_files.write_text(self.path / "metrics.csv", atomic_files.csv_text(rows))

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write what the run came to."""
        atomic_files.write_json(self.path / "summary.json", summary)
