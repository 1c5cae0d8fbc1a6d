"""Which OpenGL MuJoCo draws with on a machine that has no display."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys

from mpma_mj.errors import RenderingError

__all__ = ["choose_backend", "require_backend"]

_VARIABLE = "MUJOCO_GL"
_LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}
_NONE = "disable"

_HOW_TO_MEND = (
    "install libegl1 and libgl1-mesa-dri, or libosmesa6 (Debian's and Ubuntu's names), or train"
    " with --no-video"
)

# A context that can be made may still fail to draw, so the trial draws.
_TRIAL = """
import mujoco
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 16, 16) as renderer:
    renderer.update_scene(data)
    assert renderer.render().any()
"""

_users_choice = os.environ.get(_VARIABLE)


def choose_backend() -> None:
    """Set MUJOCO_GL to what this machine seems to have, unless the user has set it.

    MuJoCo and dm_control read it once, when they are imported, and fail there if it names a
    library that is missing. On Linux without a display: EGL, else OSMesa, else none, by
    whether the library loads. Elsewhere MuJoCo's own choice is right.
    """
    if _users_choice is None and _headless():
        os.environ[_VARIABLE] = next(filter(_loads, _LIBRARIES), _NONE)


def require_backend() -> str:
    """Find a backend that really draws, and set MUJOCO_GL to it.

    Each candidate draws a picture in a process of its own, since a failed one cannot be
    replaced within a process. To be called before MuJoCo is imported.

    Returns:
        The backend, such as "egl".

    Raises:
        RenderingError: None draws; says what to install.
    """
    if _users_choice is not None:
        candidates = [_users_choice]
    else:
        candidates = list(_LIBRARIES) if _headless() else ["glfw"]
    for backend in candidates:
        if _draws(backend):
            os.environ[_VARIABLE] = backend
            return backend
    tried = ", ".join(candidates)
    raise RenderingError(f"no video: OpenGL does not draw here (tried {tried}); {_HOW_TO_MEND}")


def _headless() -> bool:
    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return sys.platform.startswith("linux") and not display


def _loads(backend: str) -> bool:
    try:
        ctypes.CDLL(_LIBRARIES[backend])
    except OSError:
        return False
    return True


def _draws(backend: str) -> bool:
    trial = subprocess.run(
        [sys.executable, "-c", _TRIAL],
        env=os.environ | {_VARIABLE: backend},
        capture_output=True,
        timeout=60,
        check=False,
    )
    return trial.returncode == 0
