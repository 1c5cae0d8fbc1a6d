"""What is inside Gymnasium's wrappers."""

from __future__ import annotations

from typing import Any, TypeVar

from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.errors import BadOptionError

__all__ = ["unwrap"]

Env = TypeVar("Env", ImitationEnv, VectorImitationEnv)


def unwrap(env: Any, kind: type[Env]) -> Env:
    """Return the environment inside all wrappers.

    Args:
        env: Environment, perhaps wrapped.
        kind: What it has to be.

    Raises:
        BadOptionError: It is another.
    """
    inner = getattr(env, "unwrapped", env)
    if not isinstance(inner, kind):
        maker = "mpma_mj.make_vec(…)"
        if kind is ImitationEnv:
            maker = 'gymnasium.make("mpma_mj:TwoArmImitation-v0")'
        raise BadOptionError(f"env is {inner}; expected what {maker} returned")
    return inner
