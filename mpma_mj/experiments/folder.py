"""Folder of a study: its header, and a file for each finished run, so that it can be resumed."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpma_mj.errors import RunFolderError
from mpma_mj.experiments.records import Record
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.data_files import as_json, read_json, write_json
from mpma_mj.utils.folder_lock import is_empty

if TYPE_CHECKING:
    from mpma_mj.experiments.study import StudyJob

__all__ = ["HEADER", "StudyFolder"]

HEADER = "study.json"

_ELSEWHERE = "choose another folder with {out}"
_NAME_LENGTH = 100  # characters of a file's name, of 255 that file systems allow


class StudyFolder:
    """Records of a study on disk.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: Path, header: Mapping[str, Any]) -> None:
        """Check that the folder is free, or was begun with the same study; write nothing yet.

        Args:
            path: The folder.
            header: Everything that decides the results, in a form that JSON gives back unchanged.

        Raises:
            RunFolderError: It holds something else, or a study of other settings or versions.
        """
        self.path = path
        self._header = header
        self._check()

    def begin(self) -> None:
        """Write the header."""
        write_json(self.path / HEADER, self._header)

    def has(self, job: StudyJob, config: RunConfig) -> bool:
        """Return whether a run is finished."""
        return self._file(job, config).exists()

    def add(self, job: StudyJob, config: RunConfig, records: list[Record]) -> None:
        """Write the records of a run."""
        content = {"config": config.to_json(), "attempts": job.attempts, "records": records}
        write_json(self._file(job, config), content)

    def read(self, job: StudyJob, config: RunConfig) -> list[Record]:
        """Return the records of a finished run, with its `attempts`.

        Raises:
            RunFolderError: The file is damaged, or of another run.
        """
        path = self._file(job, config)
        try:
            content = read_json(path)
            attempts = int(content["attempts"])
            records = [dict(one) | {"attempts": attempts} for one in content["records"]]
            same = content["config"] == as_json(config.to_json())
        except (OSError, ValueError, KeyError, TypeError):
            raise _damaged(path, "remove it and start again") from None
        if not same:
            raise RunFolderError(f"{path}: belongs to another run; remove it to train this one")
        return records

    def _file(self, job: StudyJob, config: RunConfig) -> Path:
        """Return the path of a run's file: readable, and no other run's."""
        text = re.sub(r"[^A-Za-z0-9.]+", "-", f"{job.name}-seed-{config.seed}").strip("-")
        settings = json.dumps([job.name, config.to_json()], sort_keys=True)
        digest = hashlib.sha256(settings.encode()).hexdigest()[:8]
        return self.path / "runs" / f"{text[-_NAME_LENGTH:]}-{digest}.json"

    def _check(self) -> None:
        path, header = self.path, self.path / HEADER
        if not path.exists():
            return
        if not path.is_dir():
            raise RunFolderError(f"{path}: is a file", remedy=_ELSEWHERE)
        if is_empty(path):
            return
        try:
            found = read_json(header)
        except FileNotFoundError:
            problem = f"{path}: is not empty and contains no study"
            raise RunFolderError(problem, remedy=_ELSEWHERE) from None
        except (OSError, ValueError):
            raise _damaged(header, _ELSEWHERE) from None
        for key, wanted in self._header.items():
            if found.get(key) != wanted:
                which = _difference(key, found.get(key), wanted)
                raise RunFolderError(f"{path}: contains another study, {which}", remedy=_ELSEWHERE)


def _damaged(path: Path, remedy: str) -> RunFolderError:
    return RunFolderError(f"{path}: damaged, or not part of a study", remedy=remedy)


def _difference(name: str, found: Any, wanted: Any) -> str:
    """Return in a few words in what two headers differ; `found` may be anything."""
    if not isinstance(wanted, dict):
        return f"with {name} {found} where {wanted} is requested"
    if not isinstance(found, dict) or found.keys() != wanted.keys():
        return f"with other {name}"
    key = next(key for key in wanted if found[key] != wanted[key])
    return _difference(key, found[key], wanted[key])
