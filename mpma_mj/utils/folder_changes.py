"""Changes of several files of a folder, all of which are made or none."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterable, Iterator
from errno import EACCES, EISDIR, ENOTDIR
from pathlib import Path

from mpma_mj.errors import RunFolderError
from mpma_mj.utils.atomic_files import (
    discard,
    folder_reaches_disk,
    not_writable,
    temporary_path,
)
from mpma_mj.utils.data_files import read_json, write_json

__all__ = ["changes", "check_places", "finish", "is_unfinished"]

_COMMITTED = ".mpma.saved"  # folder of files that take their places; it exists from the commit on
_REMOVED = "gone.json"  # file in it with the names of what is removed


@contextlib.contextmanager
def changes(folder: Path, removed: Iterable[str]) -> Iterator[Path]:
    """Yield a temporary folder, whose files on success take their places in a folder: all or none.

    One rename commits them. Where a process dies before, `remove_leftovers` removes the temporary
    folder; afterwards `finish` makes the changes that are left.

    Args:
        folder: The folder, which is locked.
        removed: Names of files and folders that are removed with the commit, unless they are among
            the new ones; those of folders end in "/".

    Yields:
        The temporary folder, whose files are named as in the folder.

    Raises:
        RunFolderError: The folder cannot be written, or something is in the way.
    """
    temporary, process = temporary_path(folder / "new"), os.getpid()
    try:
        temporary.mkdir(parents=True)
        yield temporary
        if os.getpid() == process:  # a fork leaves them to its parent
            names = _names(temporary)
            old = [name for name in removed if not (temporary / name).exists()]
            check_places(folder, [*names, *old])
            write_json(temporary / _REMOVED, {"gone": old})
            temporary.rename(folder / _COMMITTED)
            folder_reaches_disk(folder)
            finish(folder)
    except OSError as error:
        raise not_writable(folder, error) from None
    finally:
        if os.getpid() == process:
            shutil.rmtree(temporary, ignore_errors=True)


def is_unfinished(folder: Path) -> bool:
    """Return whether a folder has committed changes that are not all made."""
    return (folder / _COMMITTED).exists()


def finish(folder: Path) -> None:
    """Make the committed changes of a folder, which is locked, if there are any.

    Raises:
        RunFolderError: The folder cannot be written, or its committed changes are damaged.
    """
    committed = folder / _COMMITTED
    if not is_unfinished(folder):
        return
    try:
        read = read_json(committed / _REMOVED)["gone"]
        removed = [os.fspath(name) for name in read if "\0" not in name]
        names = _names(committed)
    except (OSError, ValueError, LookupError, TypeError):
        raise RunFolderError(f"{committed}: damaged; remove it") from None
    check_places(folder, [*names, *removed])
    place = folder
    try:
        for place in (folder / name for name in removed):
            if place.is_dir() and not place.is_symlink():
                discard(place)
            else:
                place.unlink(missing_ok=True)
        for name in names:
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            (committed / name).replace(place)
        for parent in {(folder / name).parent for name in names}:
            folder_reaches_disk(parent)
        discard(committed)
    except OSError as error:
        raise not_writable(place, error) from None


def _names(temporary: Path) -> list[str]:
    """Return the names of the files that take their places."""
    files = sorted(path for path in temporary.rglob("*") if path.is_file())
    return [str(path.relative_to(temporary)) for path in files if path != temporary / _REMOVED]


def check_places(folder: Path, names: Iterable[str]) -> None:
    """Check that files and folders of these names can be written, or removed.

    Raises:
        RunFolderError: Something is in the way, a folder cannot be written, or a name leads out of
            the folder, as only a damaged or hostile one does.
    """
    root, device = folder.resolve(), folder.stat().st_dev
    for name in names:
        place = folder / name
        for parent in (place.parent, *place.parent.parents):
            if os.path.lexists(parent):
                break
        if not parent.is_dir():
            raise _refused(place, ENOTDIR)
        if not parent.resolve().is_relative_to(root) or parent.stat().st_dev != device:
            raise RunFolderError(f"{parent}: leads out of {folder}; put a folder in its place")
        if not os.access(parent, os.W_OK | os.X_OK):
            raise _refused(parent, EACCES)
        if os.path.lexists(place) and place.is_dir() != name.endswith("/"):
            raise _refused(place, EISDIR if place.is_dir() else ENOTDIR)


def _refused(path: Path, reason: int) -> RunFolderError:
    return not_writable(path, OSError(reason, os.strerror(reason)))
