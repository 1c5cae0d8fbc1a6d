"""Changes of several files of a folder, of which all are made or none."""

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

_SAVED = ".mpma.saved"  # folder of files that take their places: the changes are decided
_GONE = "gone.json"  # file in it with the names of what goes


@contextlib.contextmanager
def changes(folder: Path, gone: Iterable[str]) -> Iterator[Path]:
    """Yield a temporary folder, whose files on success take their places in a folder: all or none.

    Where a process dies before that, `remove_leftovers` removes the temporary folder; afterwards
    `finish` does what is left.

    Args:
        folder: The folder, which is locked.
        gone: Names of what goes when the files are there, unless it is one of them; those of
            folders end in "/".

    Yields:
        The temporary folder, in which names are those in the folder.

    Raises:
        RunFolderError: The folder cannot be written, or something is in the way.
    """
    temporary, process = temporary_path(folder / "new"), os.getpid()
    try:
        temporary.mkdir(parents=True)
        yield temporary
        if os.getpid() == process:
            names = _names(temporary)
            left = [name for name in gone if not (temporary / name).exists()]
            check_places(folder, [*names, *left])
            write_json(temporary / _GONE, {"gone": left})
            temporary.rename(folder / _SAVED)
            folder_reaches_disk(folder)
            finish(folder)
    except OSError as error:
        raise not_writable(folder, error) from None
    finally:
        if os.getpid() == process:
            shutil.rmtree(temporary, ignore_errors=True)


def is_unfinished(folder: Path) -> bool:
    """Return whether changes of a folder are decided that have not all been made."""
    return (folder / _SAVED).exists()


def finish(folder: Path) -> None:
    """Make the changes of a folder, which is locked, that are decided; if there are any.

    Raises:
        RunFolderError: The folder cannot be written, or what is decided is damaged.
    """
    saved = folder / _SAVED
    if not is_unfinished(folder):
        return
    try:
        gone = [os.fspath(name) for name in read_json(saved / _GONE)["gone"] if "\0" not in name]
        names = _names(saved)
    except (OSError, ValueError, LookupError, TypeError):
        raise RunFolderError(f"{saved}: damaged; remove it") from None
    check_places(folder, [*names, *gone])
    place = folder
    try:
        for place in (folder / name for name in gone):
            if place.is_dir() and not place.is_symlink():
                discard(place)
            else:
                place.unlink(missing_ok=True)
        for name in names:
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            (saved / name).replace(place)
        for parent in {(folder / name).parent for name in names}:
            folder_reaches_disk(parent)
        discard(saved)
    except OSError as error:
        raise not_writable(place, error) from None


def _names(temporary: Path) -> list[str]:
    """Return the names of the files that take their places."""
    files = sorted(path for path in temporary.rglob("*") if path.is_file())
    return [str(path.relative_to(temporary)) for path in files if path != temporary / _GONE]


def check_places(folder: Path, names: Iterable[str]) -> None:
    """Check that files and folders of these names can take their places, or go.

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
