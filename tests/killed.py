"""Processes that die at a change of a file, simulated in this process."""

from __future__ import annotations

import gc
import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest

_CHANGES = ("replace", "rename", "unlink", "remove", "mkdir", "rmdir", "fsync")
_NOBODY = 1 << 30  # number of no process


class Killed(BaseException):
    """The process does nothing any more, not even clean up."""


@contextmanager
def killed_at(number: int | None) -> Iterator[list[str]]:
    """Let all changes of files fail from one on, as if the process had been killed there.

    Args:
        number: Which change is the first that fails, from 0; None for no kill.

    Yields:
        The changes so far, by the names of the functions.
    """
    gc.collect()  # closes files of one that was killed earlier, so that its locks are free
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
        if number is not None:
            patched.setattr(os, "getpid", lambda: _NOBODY)  # so that what it leaves is nobody's
        with suppress(Killed):
            yield done
