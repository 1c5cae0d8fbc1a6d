"""Locks of folders, so that one command at a time writes into a folder."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from mpma_mj.errors import RunFolderError
from mpma_mj.utils import folder_changes
from mpma_mj.utils.atomic_files import is_temporary, not_writable, remove_leftovers

if TYPE_CHECKING:
    from filelock import FileLock

__all__ = ["finish_changes", "is_empty", "locked"]

_LOCK = ".mpma.lock"


@contextlib.contextmanager
def locked(folder: Path, *, new: bool = False) -> Iterator[None]:
    """Lock a folder, so that no other command writes into it, and clean up after killed ones.

    The operating system releases the lock when the process ends, also after a crash. At the end
    the lock's file is removed, with folders that were created for it and are still empty.

    Args:
        folder: The folder; created if it is missing.
        new: Whether the folder must not exist yet.

    Raises:
        FileExistsError: `new` is set and the folder exists.
        RunFolderError: Another command writes into the folder, or it cannot be written.
    """
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        _make(folder, new)
        lock = _acquire(folder)
        try:
            folder_changes.finish(folder)
            for place in (folder, *filter(Path.is_dir, folder.iterdir())):
                remove_leftovers(place)
            yield
        finally:
            # Before the release: a process that has opened the file by now is refused, because the
            # file is gone. Some systems do not remove open files; there filelock does.
            with contextlib.suppress(OSError):
                (folder / _LOCK).unlink()
            lock.release()
    finally:
        for path in missing:
            with contextlib.suppress(OSError):  # not empty
                path.rmdir()


def finish_changes(folder: Path) -> None:
    """Finish the changes of a folder in which a command was killed, before files are read.

    Raises:
        RunFolderError: Another command makes them at this moment, or the folder cannot be written.
    """
    if folder_changes.is_unfinished(folder):
        with locked(folder):
            pass


def is_empty(folder: Path) -> bool:
    """Return whether a folder is empty, except for a lock and files that are being written."""
    return all(path.name == _LOCK or is_temporary(path) for path in folder.iterdir())


def _make(folder: Path, new: bool) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=not new)
    except OSError as error:
        if new and isinstance(error, FileExistsError):
            raise
        raise not_writable(folder, error) from None


def _acquire(folder: Path) -> FileLock:
    from filelock import FileLock, Timeout  # takes 0.03 s, which commands that only read save

    # No soft locks on systems without locks: their file would outlast a killed process.
    lock = FileLock(folder / _LOCK, fallback_to_soft=False)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise RunFolderError(
            f"{folder}: another command is writing into it; wait until it has ended, or choose"
            " another folder"
        ) from None
    except OSError as error:
        raise not_writable(folder, error) from None
    return lock
