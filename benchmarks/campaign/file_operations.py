"""Changes of files that this process makes, numbered, so that it can die at one of them."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

__all__ = ["die_at", "list_operations", "watch"]

Seen = Callable[[str, Path], None]

_CHANGING = os.O_WRONLY | os.O_RDWR | os.O_CREAT
# Events of the interpreter, and where their arguments have paths and the folders these start from.
_PLACES = {
    "os.rename": (0, 2),
    "os.remove": (0, 1),
    "os.mkdir": (0, 2),
    "os.rmdir": (0, 1),
    "os.link": (1, 3),
    "os.symlink": (1, 2),
    "os.truncate": (0, None),
}
_TORN = b'{"torn": [1, 2, '  # beginning of a file, as of one that is being written


def watch(folder: Path, seen: Seen) -> None:
    """Call a function before each change of a file under a folder, until this process ends.

    Args:
        folder: The folder.
        seen: Takes what is going to be done and to which path.
    """
    folder = folder.resolve()

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        for path in _changed(event, arguments):
            if folder in path.parents:
                seen(event, path)

    def fsync(file: int, sync: Callable[[int], None] = os.fsync) -> None:
        path = _opened(file)
        if folder in path.parents:
            seen("os.fsync", path)
        sync(file)

    sys.addaudithook(hook)
    os.fsync = fsync  # which has no event; what was written is there, and has its temporary name


def list_operations(folder: Path, into: Path) -> None:
    """List the names of all changes under a folder in a file outside of it, a line each."""
    listed = os.open(into, os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def seen(event: str, _: Path) -> None:
        os.write(listed, f"{event}\n".encode())

    watch(folder, seen)


def die_at(folder: Path, number: int, *, torn: bool) -> None:
    """Let this process be killed before a change of a file.

    Args:
        folder: Folder whose files are meant.
        number: Which change, from 0.
        torn: Whether a file that is opened there gets a beginning first.
    """
    count = 0

    def seen(event: str, path: Path) -> None:
        nonlocal count
        count += 1  # also by the beginning that is written below
        if count == number + 1:
            if torn and event == "open" and path.parent.is_dir():
                path.write_bytes(_TORN)
            os.kill(os.getpid(), signal.SIGKILL)

    watch(folder, seen)


def _changed(event: str, arguments: tuple[Any, ...]) -> Iterator[Path]:
    """Yield the absolute path that an event changes, if any."""
    if event == "open":
        path, _, flags = arguments
        if isinstance(path, str | bytes | os.PathLike) and flags & _CHANGING:
            yield _absolute(path, None)
    elif event in _PLACES:
        place, start = _PLACES[event]
        yield _absolute(arguments[place], arguments[start] if start is not None else None)


def _absolute(path: Any, start: int | None) -> Path:
    if isinstance(path, int):
        return _opened(path)
    base = Path.cwd() if start is None or start < 0 else _opened(start)
    return Path(os.path.normpath(base.resolve() / os.fsdecode(path)))  # not where a link leads


def _opened(file: int) -> Path:
    """Return the path of an open file or folder."""
    return Path(f"/proc/self/fd/{file}").readlink()
