"""Folder of a run: config, checkpoints, trace, metrics and results."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import (
    BadOptionError,
    CheckpointError,
    MotionFileError,
    RunFolderError,
    one_line,
)
from mpma_mj.motions import Motion
from mpma_mj.motions.motion import motion_arrays, motion_of_arrays
from mpma_mj.trace import Trace, trace_problem
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.training.config_json import OutsideConfig
from mpma_mj.training.epoch_rows import EpochMetrics, row_problem
from mpma_mj.utils import atomic_files, data_files, folder_changes
from mpma_mj.utils.folder_lock import finish_changes, is_empty, locked
from mpma_mj.utils.input_files import SMALL_FILE, file_problem
from mpma_mj.utils.validation import is_integer

__all__ = ["RunFolder", "open_runs"]

Array = NDArray[np.float64]

ANALYSES = ("modules", "lesion", "free_running")
"""Names of analyses, whose results a run folder holds."""

# Results of an epoch that is no longer the best one, and further ones of a run that is replaced.
_OF_BEST = (
    *("dance.mp4", "evaluations/"),
    *(name for one in ANALYSES for name in (f"{one}.json", f"figures/{one}.png")),
)
_OF_RUN = (*_OF_BEST, "summary.json", "figures/")
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
    def sound(self) -> Path | None:
        """Copy of the music to which the motion belongs; None if none was given."""
        files = sorted((self.path / "sound").glob("[!.]*"))
        return files[0] if files else None

    @property
    def evaluations(self) -> Path:
        """Folder with a folder for each evaluation."""
        return self.path / "evaluations"

    @property
    def figures(self) -> Path:
        """Folder of the figures."""
        return self.path / "figures"

    def checkpoint(self, name: str) -> Path:
        """Return the path of an archive: best, latest or motion."""
        return self.path / "checkpoint" / f"{name}.npz"

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
        if not self.path.is_dir():
            self.read_config()
        with locked(self.path):
            self.read_config()
            yield

    def check_new(self, config: RunConfig, *, overwrite: bool) -> None:
        """Check that a new run can be saved in the folder, before it is trained.

        Args:
            config: Config of the run.
            overwrite: Whether an earlier run in the folder may be replaced.

        Raises:
            RunFolderError: The folder holds a run that must not be replaced or other files, or
                cannot be written.
            BadOptionError: JSON cannot hold the options of the agent.
            MotionFileError: The sound file cannot be read.
        """
        try:
            data_files.json_text(config.to_json())
        except (TypeError, ValueError) as error:
            expected = f"options that JSON can hold ({one_line(error)})"
            raise BadOptionError(option="agent", value=config.agent, expected=expected) from None
        if config.reading.audio is not None and (problem := file_problem(config.reading.audio)):
            raise MotionFileError(f"{config.reading.audio}: {problem}")
        if not self.path.exists():
            return
        if not self.path.is_dir():
            raise RunFolderError(f"{self.path}: is a file", remedy=_ANOTHER_FOLDER)
        finish_changes(self.path)
        if is_empty(self.path):
            return
        if not self._is_run():
            raise RunFolderError(f"{self.path}: is not empty and not a run", remedy=_ANOTHER_FOLDER)
        if not overwrite:
            raise RunFolderError(
                f"{self.path}: already contains a run",
                remedy="{overwrite} replaces it, {resume} continues it",
            )
        self.check_places()

    def check_places(self) -> None:
        """Check that the files of a run can be written; RunFolderError as of `check_new`."""
        written = ("config.json", "trace.npz", "metrics.csv", "checkpoint/latest.npz")
        folder_changes.check_places(self.path, (*written, *_OF_RUN))

    @contextlib.contextmanager
    def changes(self, *, new: bool = False, best: bool = False) -> Iterator[RunFolder]:
        """Yield a folder whose files on success become those of this one, all or none.

        Results to which they do not belong are removed at the same time; files of the user stay.

        Args:
            new: Whether they are of a new run.
            best: Whether they are of a new best epoch.

        Raises:
            RunFolderError: The folder cannot be written.
        """
        removed = _OF_RUN if new else _OF_BEST if best else ()
        sound = [f"sound/{self.sound.name}"] if new and self.sound else []
        with folder_changes.changes(self.path, [*removed, *sound]) as temporary:
            yield RunFolder(temporary)

    def write_inputs(self, config: RunConfig, motion: Motion) -> None:
        """Write config, motion and sound, with which a run is resumed without the recording."""
        content = {"format": data_files.FORMAT, "config": config.to_json(), "versions": versions()}
        data_files.write_json(self.path / "config.json", content)
        header = {"config": content["config"]}
        data_files.write_arrays(self.checkpoint("motion"), "motion", motion_arrays(motion), header)
        if config.reading.audio is not None:
            source = Path(config.reading.audio)
            with atomic_files.atomic_write(self.path / "sound" / source.name) as temporary:
                shutil.copyfile(source, temporary)

    def _is_run(self) -> bool:
        """Return whether there is a run, also a damaged one or one of another version."""
        if data_files.is_json(self.path / "config.json", {"format", "config", "versions"}):
            return True
        kinds = {"best": "checkpoint", "latest": "checkpoint", "motion": "motion"}
        archives = {self.checkpoint(name): kind for name, kind in kinds.items()}
        archives[self.path / "trace.npz"] = "trace"
        return any(data_files.is_archive(path, kind) for path, kind in archives.items())

    def read_config(self) -> RunConfig:
        """Read the config.

        Raises:
            RunFolderError: There is no run.
            CheckpointError: The config is damaged or of another version.
        """
        finish_changes(self.path)
        path = self.path / "config.json"
        try:
            content = data_files.read_json(path, largest=SMALL_FILE)
        except OSError:
            raise RunFolderError(
                f"{self.path}: is not a run (no readable config.json)",
                remedy="expected a folder that mpma imitate wrote, such as runs/ymca",
            ) from None
        except ValueError as problem:
            raise _damaged(path, str(problem)) from None
        try:
            return RunConfig.from_json(content["config"], self.trusted)
        except (AttributeError, ArithmeticError, ValueError, LookupError, TypeError) as error:
            named = isinstance(error, BadOptionError) and error.option in ("agent", "rule")
            if named and self.trusted:
                raise  # about a class that the user has named
            raise _damaged(path, "damaged, or not of a run") from None

    def read_motion(self) -> Motion:
        """Read the motion of the run.

        Raises:
            CheckpointError: The file is missing or damaged.
        """
        path = self.checkpoint("motion")
        arrays, _ = _read(path, "motion", self.read_config())
        try:
            return motion_of_arrays(arrays, path)
        except MotionFileError:
            raise _damaged(path, "damaged") from None

    def write_checkpoint(
        self, name: str, config: RunConfig, state: Mapping[str, Array], meta: dict[str, Any]
    ) -> None:
        """Write the state of an agent, with further entries of the header as in JSON.

        The file is `checkpoint/best.npz` or `latest.npz`; the config is compared on reading.
        """
        content = {"config": config.to_json()} | meta
        data_files.write_arrays(self.checkpoint(name), "checkpoint", state, content)

    def write_latest(
        self, config: RunConfig, state: Mapping[str, Array], rows: list[EpochMetrics], epochs: int
    ) -> None:
        """Write what `read_latest` reads."""
        self.write_checkpoint("latest", config, state, {"rows": rows, "epochs": epochs})

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
        return _read(self.checkpoint(name), "checkpoint", config)

    def read_best(self, config: RunConfig) -> tuple[dict[str, Array], EpochMetrics]:
        """Read the state of the agent in the best epoch, and the metrics of that epoch.

        Raises:
            CheckpointError: As of `read_checkpoint`, or the metrics are none.
        """
        state, meta = self.read_checkpoint("best", config)
        row: Any = meta.get("row")
        if problem := row_problem(row):
            raise _damaged(self.checkpoint("best"), problem)
        return state, row

    def read_latest(self, config: RunConfig) -> tuple[dict[str, Array], list[EpochMetrics], int]:
        """Read the latest state of the agent, all epochs' metrics, and their largest number.

        Raises:
            CheckpointError: As of `read_checkpoint`, or the metrics are none.
        """
        state, meta = self.read_checkpoint("latest", config)
        rows: Any = meta.get("rows")
        found = enumerate(rows, 1) if isinstance(rows, list) and rows else [(1, None)]
        if problem := next(filter(None, (row_problem(row, n) for n, row in found)), ""):
            raise _damaged(self.checkpoint("latest"), problem)
        if not is_integer(epochs := meta.get("epochs")):
            raise _damaged(self.checkpoint("latest"), "lacks its largest number of epochs")
        return state, rows, int(epochs)

    def write_trace(self, trace: Trace, config: RunConfig, epoch: int) -> None:
        """Write the trace of the best epoch."""
        header = {"epoch": epoch, "config": config.to_json()}
        data_files.write_arrays(self.path / "trace.npz", "trace", trace.to_arrays(), header)

    def read_trace(self) -> Trace:
        """Read the trace of the best epoch.

        Raises:
            CheckpointError: The file is missing or damaged, lacks a signal, or is of another run,
                or epoch than `checkpoint/best.npz`.
        """
        path, config = self.path / "trace.npz", self.read_config()
        arrays, header = _read(path, "trace", config)
        if problem := trace_problem(arrays):
            raise _damaged(path, problem)
        if (epoch := header.get("epoch")) != (best := int(self.read_best(config)[1]["epoch"])):
            raise _damaged(path, f"is of epoch {epoch}, but checkpoint/best.npz of epoch {best}")
        return Trace.from_arrays(arrays)

    def write_metrics(self, rows: list[dict[str, float]]) -> None:
        """Write the metrics of all epochs, a row for each."""
        atomic_files.write_text(self.path / "metrics.csv", data_files.csv_text(rows))

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write the summary of the run."""
        data_files.write_json(self.path / "summary.json", summary)


def _read(
    path: Path, kind: str, config: RunConfig
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Read arrays and header that were written for a run with this config."""
    arrays, header = data_files.read_arrays(path, kind)
    if header.get("config") != data_files.as_json(config.to_json()):
        raise _damaged(path, "belongs to a run with another config")
    return arrays, header


def _damaged(path: Path, problem: str) -> CheckpointError:
    is_denied = problem.startswith("cannot be read")
    remedy = "check its permissions" if is_denied else data_files.TRAIN_AGAIN
    return CheckpointError(f"{path}: {problem}", remedy=remedy)


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
