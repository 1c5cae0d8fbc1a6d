"""Folders that commands write."""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mpma_mj.utils.folder_lock import locked
from mpma_mj.utils.text import printable

if TYPE_CHECKING:
    from mpma_mj.training.run_folder import RunFolder

__all__ = ["locked_runs", "output_folder"]


@contextlib.contextmanager
def output_folder(out: Path | None, stem: str, parent: Path = Path("runs")) -> Iterator[Path]:
    """Lock the output folder of a command while the command runs.

    Args:
        out: The folder; a new one, named by the stem and the time, if not given.
        stem: Beginning of the name of a new folder.
        parent: Parent of a new folder.

    Yields:
        The folder.

    Raises:
        RunFolderError: Another command writes into the folder, or it cannot be written.
    """
    with contextlib.ExitStack() as stack:
        for folder in _new_folders(stem, parent) if out is None else [out]:
            with contextlib.suppress(FileExistsError):  # just created by another command
                stack.enter_context(locked(folder, new=out is None))
                break
        yield folder


@contextlib.contextmanager
def locked_runs(folders: Sequence[RunFolder]) -> Iterator[None]:
    """Lock runs, each once even if it is given several times.

    Raises:
        MpmaError: As of `RunFolder.locked`.
    """
    with contextlib.ExitStack() as stack:
        for folder in {folder.path.resolve(): folder for folder in folders}.values():
            stack.enter_context(folder.locked())
        yield


def _new_folders(stem: str, parent: Path) -> Iterator[Path]:
    """Yield candidates for the path of a new folder."""
    name = f"{printable(stem)}-{time.strftime('%Y%m%d-%H%M%S')}"
    yield parent / name
    yield from (parent / f"{name}-{i}" for i in itertools.count(2))
