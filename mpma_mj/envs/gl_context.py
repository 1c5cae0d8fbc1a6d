"""OpenGL contexts, each bound to the process and thread that made it."""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import functools
import os
import sys
import threading
import weakref
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import mujoco
from dm_control._render.base import ContextBase

from mpma_mj.envs.gl import INSTALL_OPENGL
from mpma_mj.errors import RenderingError

__all__ = ["BoundContext"]

T = TypeVar("T")

_contexts: weakref.WeakSet[BoundContext[Any]] = weakref.WeakSet()
_processes_that_drew: set[int] = set()  # a forked process inherits those of its parents


class BoundContext(Generic[T]):
    """A MuJoCo renderer, or another holder of an OpenGL context, for the thread that made it."""

    def __init__(self, make: Callable[[], T], release: Callable[[T], None]) -> None:
        """Make the holder.

        Args:
            make: Makes it.
            release: Releases its context.

        Raises:
            RenderingError: OpenGL does not draw on this machine, or this process was forked from
                one that has drawn.
        """
        _refuse_forked()
        try:
            self._holder = make()
        except (ImportError, AttributeError, RuntimeError, mujoco.FatalError) as error:
            raise RenderingError(
                "OpenGL cannot draw on this machine", remedy=INSTALL_OPENGL
            ) from error
        self._release = release
        self._process, here = os.getpid(), threading.current_thread()
        # With OSMesa, dm_control draws in a thread of its own, whichever thread calls it.
        draws_here = not isinstance(self._holder, ContextBase) or self._holder.thread is here
        self._thread = here if draws_here else None
        _processes_that_drew.add(self._process)
        _contexts.add(self)
        _prepare_for_forks()
        # Called in reverse order: before the handlers that the backend has registered just now.
        atexit.unregister(_end_all)
        atexit.register(_end_all)

    def get(self) -> T:
        """Return the holder, to draw with it now.

        Raises:
            RenderingError: This is another thread, or a process that was forked.
        """
        if self._process != os.getpid():
            _refuse_forked()
        if self._thread not in (None, threading.current_thread()):
            raise RenderingError(
                "no picture: another thread has drawn this environment",
                remedy="draw in one thread, or make an environment for each",
            )
        return self._holder

    def release(self) -> None:
        """Release the context, except for a parent's: that would hang."""
        if self._process == os.getpid():
            self._release(self._holder)

    def abandon(self) -> None:
        """Let nothing release the context, neither a collection nor the end of the process."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._holder))
        if isinstance(self._holder, ContextBase):
            self._holder._render_executor.terminate()

    def end(self) -> None:
        """Release the context when the process ends; that of another thread cannot be."""
        self.release() if self._thread is threading.current_thread() else self.abandon()


def _refuse_forked() -> None:
    """Raise where a parent has drawn: OpenGL's threads are not forked, and drawing hangs."""
    if _processes_that_drew - {os.getpid()}:
        raise RenderingError(
            "no picture: this process was forked from one that has drawn",
            remedy='use spawn, not fork, to start it: multiprocessing.get_context("spawn"),'
            ' start_method="spawn" or context="spawn"',
        )


@functools.cache
def _prepare_for_forks() -> None:
    """Let forked processes abandon their parents' contexts: releasing one would hang."""
    with contextlib.suppress(AttributeError):  # on Windows, which does not fork
        os.register_at_fork(after_in_child=_abandon_all)


def _abandon_all() -> None:
    for context in list(_contexts):
        context.abandon()
    if egl := sys.modules.get("OpenGL.EGL"):
        atexit.unregister(egl.eglTerminate)  # which waits for threads that were not forked


def _end_all() -> None:
    """Release the contexts that are still open; after OpenGL's end that prints tracebacks."""
    for context in list(_contexts):
        context.end()
