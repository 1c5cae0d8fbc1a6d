"""Processes that die at a change of a file, simulated in this process."""

from __future__ import annotations

import io
import os
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from mpma_mj.utils import atomic_files

_CHANGES = ("replace", "rename", "unlink", "remove", "mkdir", "rmdir")
_NOBODY = 1 << 30  # number of no process


class Killed(BaseException):
    """The process does nothing any more, not even clean up."""


def _close_files(killed: BaseException) -> None:
    """Close what the process had open, so that its locks are free."""
    error: BaseException | None = killed
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        error = error.__context__


class _OsOfNobody:
    """The module `os` of a process that is there no more."""

    def __getattr__(self, name: str) -> Any:
        return (lambda: _NOBODY) if name == "getpid" else getattr(os, name)


@contextmanager
def killed_at(number: int | None) -> Iterator[list[str]]:
    """Let all changes of files fail from one on, as if the process had been killed there.

    Args:
        number: Which change is the first that fails, from 0; None for no kill.

    Yields:
        The changes so far, by the names of the functions.
    """
    done: list[str] = []

    def counted(name: str, do: Callable[..., Any]) -> Callable[..., Any]:
        def change(*arguments: Any, **options: Any) -> Any:
            mode = arguments[1] if len(arguments) > 1 else options.get("mode", "r")
            if name != "open" or not str(mode).startswith("r"):
                if number is not None and len(done) >= number:
                    raise Killed
                done.append(name)
            return do(*arguments, **options)

        return change

    with pytest.MonkeyPatch.context() as patched:
        for name in _CHANGES:
            patched.setattr(os, name, counted(name, getattr(os, name)))
        patched.setattr(io, "open", counted("open", io.open))
        patched.setattr(os, "fsync", counted("fsync", lambda _: None))  # the machine does not crash
        if number is not None:
            patched.setattr(atomic_files, "os", _OsOfNobody())  # so that what it leaves is nobody's
        try:
            yield done
        except Killed as killed:
            _close_files(killed)
