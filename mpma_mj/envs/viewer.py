"""A window that shows the arms, at the speed of life, beside the demonstration's ghost."""

from __future__ import annotations

import time
import warnings
from typing import Any

import mujoco
import mujoco.viewer
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import add_ghost
from mpma_mj.errors import RenderingError

__all__ = ["ArmViewer"]

_ADVICE = 'use render_mode="rgb_array"'


class ArmViewer:
    """MuJoCo's own window on one environment's arms; does not step the simulation."""

    def __init__(self, physics: PhysicsArms, period: float) -> None:
        """Open the window.

        Args:
            physics: The arms.
            period: Least time from one `show` to the next, s.

        Raises:
            RenderingError: There is no display.
        """
        self._physics = physics
        self._period = period
        self._shown = 0.0
        self._window = _open(physics)

    def show(self, ghost: NDArray[np.float64]) -> None:
        """Show the arms as they are now; nothing once the user has closed the window.

        Args:
            ghost: Demonstrated posture, shape (12,).
        """
        if not self._window.is_running():
            return
        with self._window.lock():
            self._window.user_scn.ngeom = 0
            add_ghost(self._window.user_scn, self._physics, ghost)
        self._window.sync()
        time.sleep(max(0.0, self._shown + self._period - time.monotonic()))
        self._shown = time.monotonic()

    def close(self) -> None:
        """Close the window."""
        self._window.close()


def _open(physics: PhysicsArms) -> Any:
    # Asked here, since where the window's own thread fails `launch_passive` waits for ever.
    if not _there_is_a_display():
        raise RenderingError(f"no window: there is no display here; {_ADVICE}")
    whole = mujoco.mjtState.mjSTATE_INTEGRATION
    state = physics.get_state(whole)
    try:
        window = mujoco.viewer.launch_passive(physics.model.ptr, physics.data.ptr)
    except RuntimeError as error:  # macOS, where windows belong to the main thread
        raise RenderingError(f"no window without mjpython; run that, or {_ADVICE}") from error
    physics.set_state(state, whole)  # the forward pass of opening leaves a trace in it
    return window


def _there_is_a_display() -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # how glfw says why not
        try:
            import glfw

            return bool(glfw.init())
        except ImportError:
            return False
