"""The folder of a sweep: what was spec, and a file for every run that is over."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpma_mj.errors import RunFolderError
from mpma_mj.experiments.spec import SweepSpec
from mpma_mj.training.config import RunConfig, versions
from mpma_mj.utils import atomic_files
from mpma_mj.utils.folder_lock import is_empty

__all__ = ["RunResult", "SweepFolder", "check_folder", "flat", "read_json"]

_KIND = "sweep"
_ELSEWHERE = "choose another folder with {out}"
_NAME_LENGTH = 100  # letters of a file's name, of 255 that file systems allow


@dataclass(frozen=True)
class RunResult:
    """A run that is over.

    Attributes:
        config: Its settings.
        summary: What it came to, as of `Trainer.summary`; or {"failed": why}.
        attempts: How often it was begun; more than once if its worker died.
        seconds: Its share of the time that the runs took which were trained side by side, s.
    """

    config: RunConfig
    summary: dict[str, Any]
    attempts: int
    seconds: float

    @property
    def diverged(self) -> bool:
        """Whether it came to no end that can be measured."""
        return "failed" in self.summary


class SweepFolder:
    """Results on disk, so that a sweep that was interrupted goes on where it was.

    Attributes:
        path: The folder.
        spec: What the sweep is.
    """

    def __init__(self, path: Path, spec: SweepSpec) -> None:
        """Look whether the folder is free, or holds this very sweep; write nothing yet.

        Raises:
            RunFolderError: It holds something else, or a sweep of other settings or versions.
        """
        self.path = path
        self.spec = spec
        self._names = {config: _name(config, spec.varying) for config in spec.configs}
        check_folder(path, self._header.name, self._content())

    @property
    def begun(self) -> bool:
        """Whether the specification is written, so that the sweep can be resumed."""
        return self._header.exists()

    def begin(self) -> None:
        """Write the specification, if it is not written yet."""
        if not self.begun:
            atomic_files.write_json(self._header, self._content())

    def add(self, run: RunResult) -> None:
        """Write the file of a run."""
        content = {
            "config": run.config.to_json(),
            "attempts": run.attempts,
            "seconds": run.seconds,
            "summary": run.summary,
        }
        atomic_files.write_json(self._file(run.config), content)

    def missing(self) -> list[RunConfig]:
        """Return the configs of the runs that are not finished."""
        return [config for config in self.spec.configs if not self._file(config).exists()]

    def finished(self) -> list[RunResult]:
        """Read the finished runs, in the order of the specification.

        Raises:
            RunFolderError: The file of a run is damaged.
        """
        return [self._read(c) for c in self.spec.configs if self._file(c).exists()]

    def add_seconds(self, seconds: float) -> None:
        """Add to the time that training has taken, which `seconds` returns."""
        atomic_files.write_json(self._clock, {"training_seconds": self.seconds() + seconds})

    def seconds(self) -> float:
        """Return how long training has taken so far, over all times the sweep was started, s."""
        try:
            return float(read_json(self._clock)["training_seconds"])
        except FileNotFoundError:
            return 0.0
        except (OSError, ValueError, KeyError, TypeError):
            raise _damaged(self._clock) from None

    def write_rows(self, runs: Iterable[RunResult]) -> None:
        """Write `results.csv`: a row for each run, what it came to and the settings that vary."""
        varying = self.spec.varying
        rows = [
            {name: run.config.option(name) for name in (*varying, "seed")}
            | {"attempts": run.attempts}
            | flat(run.summary)
            for run in runs
        ]
        atomic_files.write_text(self.path / "results.csv", atomic_files.csv_text(rows))

    def title(self, config: RunConfig) -> str:
        """Return the settings of a run that vary, but for the seed, in words."""
        shown = (f"{name} {_told(config.option(name))}" for name in self.spec.varying)
        return ", ".join(shown)

    @property
    def _header(self) -> Path:
        return self.path / "sweep.json"

    @property
    def _clock(self) -> Path:
        return self.path / "time.json"

    def _file(self, config: RunConfig) -> Path:
        return self.path / "runs" / f"{self._names[config]}.json"

    def _content(self) -> dict[str, Any]:
        """Return what is spec, in a form that JSON gives back unchanged."""
        names = (*self.spec.varying, "seed")
        configs = [config.options() for config in self.spec.configs]
        content = {
            "kind": _KIND,
            "format": atomic_files.FORMAT,
            "versions": versions(),
            "epochs": self.spec.epochs,
            "stop": self.spec.stop,
            "settings": {k: v for k, v in configs[0].items() if k not in names},
            "runs": [{name: config.get(name) for name in names} for config in configs],
        }
        return json.loads(json.dumps(content, default=str))

    def _read(self, config: RunConfig) -> RunResult:
        path = self._file(config)
        try:
            content = read_json(path)
            run = RunResult(
                config,
                dict(content["summary"]),
                content["attempts"],
                content["seconds"],
            )
        except (OSError, ValueError, KeyError, TypeError):
            raise _damaged(path) from None
        if content["config"] != json.loads(json.dumps(config.to_json())):
            raise RunFolderError(f"{path}: is of another run; remove it, and it is trained anew")
        return run


def check_folder(path: Path, header: str, content: Mapping[str, Any]) -> None:
    """Check that a folder is free, or was begun with the same header.

    Args:
        path: The folder.
        header: Name of the file with the header.
        content: The header, in a form that JSON gives back unchanged; its `kind` says what the
            folder holds.

    Raises:
        RunFolderError: It holds something else, or the same with other settings or versions.
    """
    if not path.exists():
        return
    if not path.is_dir():
        raise RunFolderError(f"{path}: is a file", remedy=_ELSEWHERE)
    if is_empty(path):
        return
    kind = content["kind"]
    try:
        there = read_json(path / header)
    except FileNotFoundError:
        problem = f"{path}: is not empty and holds no {kind}"
        raise RunFolderError(problem, remedy=_ELSEWHERE) from None
    except (OSError, ValueError):
        raise _damaged(path / header, _ELSEWHERE, kind) from None
    differing = [key for key in content if there.get(key) != content[key]]
    if differing:
        which = _difference(differing[0], there.get(differing[0]), content[differing[0]])
        raise RunFolderError(f"{path}: holds another {kind}, {which}", remedy=_ELSEWHERE)


def read_json(path: Path) -> dict[str, Any]:
    """Read an object.

    Raises:
        OSError: The file cannot be read.
        ValueError: It holds something else.
    """
    content = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict):
        raise ValueError("not an object")
    return content


def _told(value: object) -> str:
    """Return a setting in a few words, however many movements there are."""
    if not isinstance(value, tuple):
        return str(value)
    first, *others = value
    return f"{first} and {len(others)} more" if others else str(first)


def _damaged(
    path: Path, remedy: str = "remove it and start again", kind: str = _KIND
) -> RunFolderError:
    return RunFolderError(f"{path}: damaged, or not of a {kind}", remedy=remedy)


def _difference(key: str, there: Any, spec: Any) -> str:
    """Say in a few words in what two sweeps differ; `there` may be anything."""
    if isinstance(there, dict) and there.keys() == spec.keys():
        name = next(name for name in spec if there[name] != spec[name])
        return f"with {name} {there[name]} where {spec[name]} is requested"
    if isinstance(there, list) and len(there) != len(spec):
        return f"of {len(there)} runs where {len(spec)} are requested"
    if isinstance(spec, dict | list):
        return "of another grid"
    return f"with {key} {there} where {spec} is requested"


def _name(config: RunConfig, varying: Iterable[str]) -> str:
    """Return a name that tells the settings that vary and is no other run's."""
    told = [f"{name}-{config.option(name)}" for name in varying] + [f"seed-{config.seed}"]
    text = re.sub(r"[^A-Za-z0-9.-]+", "-", "-".join(told))
    settings = json.dumps(config.to_json(), sort_keys=True)
    return f"{text[:_NAME_LENGTH]}-{hashlib.sha256(settings.encode()).hexdigest()[:8]}"


def flat(summary: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a summary without its branches, `active_modules.Y` and so on."""
    leaves: dict[str, Any] = {}
    for name, value in summary.items():
        if isinstance(value, Mapping):
            leaves |= flat(value, f"{prefix}{name}.")
        else:
            leaves[f"{prefix}{name}"] = value
    return leaves
