"""Atomic writing of files and folders: under a temporary name in the same folder, then renamed."""

from __future__ import annotations

import contextlib
import errno
import os
import platform
import re
import shutil
import zlib
from collections.abc import Iterator
from pathlib import Path

from mpma_mj.errors import RunFolderError

__all__ = [
    "atomic_folder",
    "atomic_write",
    "discard",
    "folder_reaches_disk",
    "is_temporary",
    "not_writable",
    "remove_leftovers",
    "temporary_path",
    "write_text",
]

_PREFIX, _EARLIER = ".mpma-", ".mpma-earlier-"
_TEMPORARY = re.compile(r"\.mpma-(?P<process>\d+)-(?P<machine>[0-9a-f]{8})-")
_CANNOT_WAIT = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)  # of file systems without fsync
_IN_THE_WAY = "remove it, or choose another folder"
_NAME_LENGTH = 80  # bytes of a name in a temporary one, of 255 that file systems allow


@contextlib.contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary path, which is renamed on success and removed on failure.

    What was written reaches the disk before the rename, so that after a crash of the machine there
    is the old file or the new one.

    Args:
        path: Path of the file; missing folders are created.

    Yields:
        The temporary path, which has the same suffix.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    temporary, process = temporary_path(path), os.getpid()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        if os.getpid() == process:
            _reach_disk(temporary)
            temporary.replace(path)
            folder_reaches_disk(path.parent)
    except OSError as error:
        raise not_writable(path, error) from None
    finally:
        if os.getpid() == process:  # not in one forked meanwhile: the parent is still writing
            with contextlib.suppress(OSError):
                temporary.unlink()


@contextlib.contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield a new temporary folder, which on success takes the place of the one of that path.

    Where a process dies between the two renames of that, `remove_leftovers` renames the earlier
    folder back.

    Args:
        path: Path of the folder, in one that is locked; missing parents are created.

    Yields:
        The absolute path of the temporary folder.

    Raises:
        RunFolderError: The folder cannot be written.
    """
    path = path.absolute()
    temporary, earlier = temporary_path(path), path.with_name(f"{_EARLIER}{path.name}")
    try:
        temporary.mkdir(parents=True)
        yield temporary
        for content in filter(Path.is_file, temporary.rglob("*")):
            _reach_disk(content)
        if path.exists():
            path.rename(earlier)
        temporary.rename(path)
        folder_reaches_disk(path.parent)
    except OSError as error:
        raise not_writable(path, error) from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        _settle(earlier)


def discard(folder: Path) -> None:
    """Remove a folder, as a whole also where the process dies meanwhile.

    Raises:
        OSError: It cannot be renamed.
    """
    temporary = temporary_path(folder)
    folder.rename(temporary)
    shutil.rmtree(temporary, ignore_errors=True)


def is_temporary(path: Path) -> bool:
    """Return whether a path has the temporary name of a file or folder that is being written."""
    return path.name.startswith(_PREFIX)


def remove_leftovers(folder: Path) -> None:
    """Remove temporary files and folders that processes of this machine left when they died."""
    with contextlib.suppress(OSError):  # also where there is no such folder
        for path in list(folder.iterdir()):
            if path.name.startswith(_EARLIER):
                _settle(path)
            elif _is_leftover(path.name):
                with contextlib.suppress(OSError):  # of another user
                    shutil.rmtree(path) if path.is_dir() else path.unlink()


def _settle(earlier: Path) -> None:
    """Remove a folder that was to be replaced, or rename it back if nothing replaced it."""
    with contextlib.suppress(OSError):
        path = earlier.with_name(earlier.name.removeprefix(_EARLIER))
        shutil.rmtree(earlier) if path.exists() else earlier.rename(path)


def temporary_path(path: Path) -> Path:
    """Return a path in the same folder, with the same suffix, that names machine and process."""
    name = path.name.encode(errors="surrogateescape")[-_NAME_LENGTH:]
    text = name.decode(errors="ignore")
    return path.with_name(f".mpma-{os.getpid()}-{_machine()}-{text}")


def _machine() -> str:
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _is_leftover(name: str) -> bool:
    """Return whether a name is the temporary one of a process of this machine that has ended."""
    found = _TEMPORARY.match(name)
    if found is None or found["machine"] != _machine() or os.name != "posix":
        return False
    try:
        os.kill(int(found["process"]), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        pass  # a process of somebody else
    return False


def _reach_disk(path: Path) -> None:
    """Wait until a file, or the names in a folder, have reached the disk.

    Raises:
        OSError: The disk is full, or fails.
    """
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    except OSError as error:
        if error.errno not in _CANNOT_WAIT:
            raise
    finally:
        os.close(opened)


def folder_reaches_disk(folder: Path) -> None:
    """Wait until the names in a folder have reached the disk, where that is possible."""
    with contextlib.suppress(OSError):  # one that may be written but not read, and Windows
        _reach_disk(folder)


def not_writable(path: Path, error: OSError) -> RunFolderError:
    """Return the error for a file or folder that cannot be written, also under a temporary name."""
    path = Path(*(part for part in path.parts if not is_temporary(Path(part))))
    if isinstance(error, IsADirectoryError):
        return RunFolderError(f"{path}: is a folder, not a file; {_IN_THE_WAY}")
    if isinstance(error, NotADirectoryError | FileExistsError):
        for file in filter(Path.is_file, (path, *path.parents)):
            return RunFolderError(f"{file}: is a file, not a folder; {_IN_THE_WAY}")
    reason = error.strerror or error
    return RunFolderError(
        f"{path}: cannot be written ({reason}); fix that, or choose another folder"
    )


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file; characters that UTF-8 cannot encode become escapes."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")
