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
_KNOWN = {*_LIBRARIES, "glfw", "", "cgl", "wgl", "glx", _NONE, "disabled", "off", "false", "0"}

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

# As the user left it: MuJoCo sets variables of its own when it is imported.
_users_environment = dict(os.environ)
_users_choice = _users_environment.get(_VARIABLE)


def choose_backend() -> None:
    """Set MUJOCO_GL to what this machine seems to have, unless the user has set it.

    MuJoCo and dm_control read it once, when they are imported, and fail there if it names a
    library that is missing. On Linux without a display: EGL, else OSMesa, else none, by
    whether the library loads. Elsewhere MuJoCo's own choice is right. A choice of the user's
    that cannot work is replaced by none; `require_backend` says so when something is drawn.
    """
    if _users_choice is None:
        if _headless():
            os.environ[_VARIABLE] = next(filter(_loads, _LIBRARIES), _NONE)
    elif _users_choice not in _KNOWN or not _loads(_users_choice):
        # MuJoCo could not even be imported; without OpenGL, all but drawing works.
        os.environ[_VARIABLE] = _NONE


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
    if backend not in _LIBRARIES:
        return True
    try:
        ctypes.CDLL(_LIBRARIES[backend])
    except OSError:
        return False
    return True


def _draws(backend: str) -> bool:
    command = [sys.executable, "-c", _TRIAL]
    environment = _users_environment | {_VARIABLE: backend}
    try:
        subprocess.run(command, env=environment, capture_output=True, timeout=60, check=True)
    except subprocess.SubprocessError:
        return False
    return True
