"""Choice of the OpenGL backend of MuJoCo on machines without a display."""

from __future__ import annotations

import contextlib
import functools
import importlib
import os
import subprocess
import sys
import types
from typing import Any

from mpma_mj.errors import RenderingError

__all__: list[str] = [
    "INSTALL_OPENGL",
    "choose_backend",
    "defer_opengl",
    "environment_of",
    "require_backend",
]

_VARIABLE = "MUJOCO_GL"
_LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}
_NONE = "disable"
# Values that both MuJoCo and dm_control accept, in lower case, in addition to the libraries above.
_KNOWN = {"glfw", "on", "enable", "enabled", "true", "1", ""} | {
    *(_NONE, "disabled", "off", "false", "0")
}

INSTALL_OPENGL = (
    "install libegl1 and libgl1-mesa-dri, or libosmesa6 (names of Debian and Ubuntu), or do without"
    " pictures"
)
"""Remedy where OpenGL does not draw."""

# A context that can be created may still fail to draw, so the trial draws.
_TRIAL = """
import mujoco
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 16, 16) as renderer:
    renderer.update_scene(data)
    assert renderer.render().any()
"""

# Modules that load an OpenGL library when they are imported, with their context classes.
_CONTEXTS = {
    "dm_control._render.pyopengl.egl_renderer": "EGLContext",
    "dm_control._render.pyopengl.osmesa_renderer": "OSMesaContext",
    "mujoco.egl": "GLContext",
    "mujoco.osmesa": "GLContext",
}

# Before MuJoCo is imported, which sets variables itself.
_users_environment = dict(os.environ)
_users_choice = _users_environment.get(_VARIABLE)
if _users_choice is not None:
    _users_choice = _users_choice.strip().lower()  # as MuJoCo reads it; dm_control does not


def choose_backend() -> None:
    """Set MUJOCO_GL to a backend that this machine seems to have, unless the user has set it.

    MuJoCo and dm_control read it once, when they are imported, and fail there if it names a
    library that is missing. On Linux without a display: EGL, else OSMesa, else none, by
    whether the library loads. Elsewhere MuJoCo's own choice is right. A user's choice that cannot
    work is replaced by none; `require_backend` reports it before something is drawn.
    """
    if _users_choice is None:
        if _headless():
            os.environ[_VARIABLE] = next(filter(_loads, _LIBRARIES), _NONE)
    else:
        # Where MuJoCo could not even be imported, all but drawing works without OpenGL.
        os.environ[_VARIABLE] = _users_choice if _can_be_imported(_users_choice) else _NONE


def defer_opengl() -> None:
    """Let MuJoCo and dm_control load OpenGL with the first context, not on import.

    Mesa's software drivers load LLVM, and so does Triton, PyTorch's compiler; a process that loads
    Mesa first crashes when it uses PyTorch. So the first context loads Triton, where it is
    installed. Modules that are already imported stay as they are.
    """
    for name, context in _CONTEXTS.items():
        if name not in sys.modules:
            deferred = types.ModuleType(name, "Stand-in until the first OpenGL context.")
            setattr(deferred, context, functools.partial(_make_context, deferred, context))
            sys.modules[name] = deferred


def _make_context(deferred: types.ModuleType, context: str, *size: Any, **options: Any) -> Any:
    """Import the module behind a stand-in and return a new context."""
    with contextlib.suppress(ImportError):
        importlib.import_module("triton")
    name = deferred.__name__
    if sys.modules.get(name) is deferred:
        del sys.modules[name]
    return getattr(importlib.import_module(name), context)(*size, **options)


def require_backend() -> str:
    """Find a backend that draws, and set MUJOCO_GL to it.

    Each candidate draws a picture in a separate process, since a failed one cannot be replaced
    within a process. To be called before MuJoCo is imported.

    Returns:
        The backend, such as "egl".

    Raises:
        RenderingError: None draws; names the packages to install.
    """
    if _users_choice is not None:
        candidates = [_users_choice]
    elif sys.platform.startswith("linux"):
        candidates = [*([] if _headless() else ["glfw"]), *_LIBRARIES]
    else:
        candidates = [""]  # MuJoCo's own choice
    for backend in candidates:
        if _draws(backend):
            os.environ[_VARIABLE] = backend
            return backend
    tried = ", ".join(candidates) or "MuJoCo's own choice"
    if _users_choice is not None:
        raise RenderingError(
            f"no video: MUJOCO_GL={_users_choice} cannot draw on this machine",
            remedy=f"unset it, or {INSTALL_OPENGL}",
        )
    raise RenderingError(
        f"no video: OpenGL cannot draw on this machine (tried {tried})", remedy=INSTALL_OPENGL
    )


def environment_of(backend: str) -> dict[str, str]:
    """Return the environment variables of a process that draws with a backend."""
    # MuJoCo sets PyOpenGL's variable for its own backend, and child processes inherit it.
    inherited = {k: v for k, v in _users_environment.items() if k != "PYOPENGL_PLATFORM"}
    return inherited | {_VARIABLE: backend}


def _headless() -> bool:
    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return sys.platform.startswith("linux") and not display


def _can_be_imported(choice: str) -> bool:
    """Return whether MuJoCo and dm_control can be imported with a user's choice."""
    if not sys.platform.startswith("linux"):
        return True
    return _loads(choice) if choice in _LIBRARIES else choice in _KNOWN


def _loads(backend: str) -> bool:
    """Return whether a backend's library loads; tried in a process, since it may load LLVM."""
    trial = f"import ctypes; ctypes.CDLL({_LIBRARIES[backend]!r})"
    command = [sys.executable, "-I", "-S", "-c", trial]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _draws(backend: str) -> bool:
    command, variables = [sys.executable, "-c", _TRIAL], environment_of(backend)
    try:
        subprocess.run(command, env=variables, capture_output=True, timeout=60, check=True)
    except subprocess.SubprocessError:
        return False
    return True
