"""Window that shows the arms and the demonstration's ghost in real time."""

from __future__ import annotations

import atexit
import sys
import threading
import time
import warnings
import weakref
from collections.abc import Callable, Mapping
from typing import Any

import mujoco
import mujoco.viewer
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.cameras import free_camera
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import add_ghost
from mpma_mj.errors import RenderingError

__all__: list[str] = ["ArmViewer"]

_INSTEAD = 'use render_mode="rgb_array"'

_viewers: weakref.WeakSet[ArmViewer] = weakref.WeakSet()


class ArmViewer:
    """MuJoCo's window on one environment's arms; does not step the simulation."""

    def __init__(
        self,
        physics: PhysicsArms,
        period: float,
        *,
        camera: str = "front",
        instead: str = _INSTEAD,
        on_key: Callable[[int], None] | None = None,
    ) -> None:
        """Open the window.

        Args:
            physics: The arms.
            period: Least time from one `show` to the next, s.
            camera: Camera of the model from whose view the mouse moves on.
            instead: Remedy in the error where no window can be opened.
            on_key: Called with the GLFW code of every key pressed, in the window's thread.

        Raises:
            BadOptionError: The model has no such camera.
            RenderingError: There is no display, or it does not draw, or a window is open already.
        """
        if any(viewer.is_open for viewer in _viewers):
            raise RenderingError("no second window: MuJoCo opens one at a time", remedy=instead)
        self._physics = physics
        self._period = period
        self._shown = 0.0
        before = threading.enumerate()
        self._window = _open(physics, free_camera(physics, camera), instead, on_key)
        self._threads = [t for t in threading.enumerate() if t not in before]
        _viewers.add(self)
        # A process that ends while the window is drawn crashes.
        atexit.register(self.close)

    @property
    def is_open(self) -> bool:
        """Whether the user has not closed the window."""
        return bool(self._window.is_running())

    def show(
        self,
        ghost: NDArray[np.float64],
        *,
        above: Mapping[str, str] | None = None,
        below: Mapping[str, str] | None = None,
    ) -> None:
        """Show the arms in their present state; nothing once the user has closed the window.

        Args:
            ghost: Demonstrated posture, shape (12,).
            above: Names and values in the upper left corner.
            below: Names and values in the lower left corner.
        """
        if not self.is_open:
            return
        with self._window.lock():
            self._window.user_scn.ngeom = 0
            add_ghost(self._window.user_scn, self._physics, ghost)
        grid = mujoco.mjtGridPos
        corners = {grid.mjGRID_TOPLEFT: above, grid.mjGRID_BOTTOMLEFT: below}
        texts = [_table(corner, rows) for corner, rows in corners.items() if rows]
        try:
            if texts:
                self._window.set_texts(texts)
            self._window.sync()
        except mujoco.UnexpectedError:
            if self.is_open:  # not closed in the meantime
                raise
        time.sleep(max(0.0, self._shown + self._period - time.monotonic()))
        self._shown = time.monotonic()

    def close(self) -> None:
        """Close the window and wait for its thread."""
        atexit.unregister(self.close)
        if self.is_open:
            self._window.close()
        for thread in self._threads:
            thread.join()


def _table(corner: mujoco.mjtGridPos, rows: Mapping[str, str]) -> tuple[Any, ...]:
    columns = ("\n".join(rows), "\n".join(rows.values()))
    # The window's font has ASCII characters only.
    return None, corner, *(text.encode("ascii", "replace").decode() for text in columns)


def _open(
    physics: PhysicsArms,
    camera: mujoco.MjvCamera,
    instead: str,
    on_key: Callable[[int], None] | None,
) -> Any:
    # Checked here, since `launch_passive` hangs or ends the process where its thread fails.
    missing = _missing_display()
    if missing is not None:
        raise RenderingError(f"no window: {missing}", remedy=instead)
    try:
        window = mujoco.viewer.launch_passive(
            physics.model.ptr,
            physics.data.ptr,
            key_callback=on_key,
            show_left_ui=False,
            show_right_ui=False,
        )
    except RuntimeError as error:  # macOS, where windows belong to the main thread
        raise RenderingError(
            "no window without mjpython",
            remedy="start it in place of python (mjpython -m mpma_mj instead of mpma),"
            f" or {instead}",
        ) from error
    with window.lock():
        window.cam.lookat[:] = camera.lookat
        for name in ("distance", "azimuth", "elevation"):
            setattr(window.cam, name, getattr(camera, name))
    return window


def _missing_display() -> str | None:
    """Return why no window can be opened, None where one can."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # how glfw reports the reason
        try:
            import glfw
        except ImportError:
            return "there is no display here"
        if not glfw.init():
            return "there is no display here"
        if sys.platform == "darwin":
            return None  # a trial would have to be on the main thread
        glfw.window_hint(glfw.VISIBLE, False)
        trial = glfw.create_window(16, 16, "", None, None)
        glfw.default_window_hints()
        if not trial:
            return "OpenGL does not draw on this display"
        glfw.destroy_window(trial)
        return None
