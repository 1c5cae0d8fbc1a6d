"""Imitation of motion-capture recordings by two simulated arms.

A MuJoCo environment in which two arms imitate recorded motions, and agents that learn to control
them, such as the Multiple Paired Models Architecture (MPMA) of Tidemann & Öztürk (2008).

    env = mpma_mj.load("ymca", arms="physics", seed=0)      # a dm_env.Environment
    motion = mpma_mj.read_motion("dance.tsv")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mpma_mj._version import __version__
from mpma_mj.envs.gl import choose_backend, defer_opengl
from mpma_mj.envs.registration import register

if TYPE_CHECKING:
    from mpma_mj.agents import MPMAConfig
    from mpma_mj.envs.load import load
    from mpma_mj.envs.vector_env import make_vec
    from mpma_mj.motions import Motion, read_motion
    from mpma_mj.training.factory import make_agent
    from mpma_mj.training.run import Run, imitate, load_agent

__all__ = [
    "MPMAConfig",
    "Motion",
    "Run",
    "__version__",
    "imitate",
    "load",
    "load_agent",
    "make_agent",
    "make_vec",
    "read_motion",
]

choose_backend()  # before MuJoCo is imported, which reads the choice on import
defer_opengl()
register()  # with Gymnasium, which imports this package to find its environments

_MODULES = {
    "MPMAConfig": "mpma_mj.agents",
    "Motion": "mpma_mj.motions",
    "Run": "mpma_mj.training.run",
    "imitate": "mpma_mj.training.run",
    "load": "mpma_mj.envs.load",
    "load_agent": "mpma_mj.training.run",
    "make_agent": "mpma_mj.training.factory",
    "make_vec": "mpma_mj.envs.vector_env",
    "read_motion": "mpma_mj.motions",
}


def __getattr__(name: str) -> Any:
    """Import a public name on first access, so that `import mpma_mj` stays fast."""
    if name not in _MODULES:
        raise AttributeError(f"module 'mpma_mj' has no attribute '{name}'")
    import importlib

    return getattr(importlib.import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    """Return all public names, including those not imported yet."""
    return __all__
