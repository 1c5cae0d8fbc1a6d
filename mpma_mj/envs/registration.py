"""Registration with Gymnasium, which imports nothing, so that it costs nothing without it."""

from __future__ import annotations

import sys

__all__ = ["ENVIRONMENTS", "register"]

ENVIRONMENTS = {
    "TwoArmImitation-v0": "mpma_mj.envs.gym:ImitationEnv",
    "TwoArmImitationFlat-v0": "mpma_mj.envs.gym:FlatImitationEnv",
}
"""Where Gymnasium finds the environment of each name, once it is asked for."""


def register() -> None:
    """Register the environments with Gymnasium: now, or as soon as it has been imported.

    `gymnasium.make("mpma_mj:…")` imports this package in order to have it registered. Where the
    package was imported first, that import does nothing any more; Gymnasium has no other hook.
    """
    if not _register_now():
        sys.meta_path.insert(0, _Listener())


def _register_now() -> bool:
    """Tell whether Gymnasium's registry was there to register with."""
    registration = sys.modules.get("gymnasium.envs.registration")
    enter = getattr(registration, "register", None)  # while it is being imported: not yet
    if registration is None or enter is None:
        return False
    for name, entry_point in ENVIRONMENTS.items():
        if name not in registration.registry:
            enter(id=name, entry_point=entry_point)
    return True


class _Listener:
    """Finds no module, but hears of each import: those that follow the registry's too."""

    def find_spec(self, fullname: str, path: object, target: object = None) -> None:
        if _register_now():
            # A new list: the import that is under way goes through the old one.
            sys.meta_path = [finder for finder in sys.meta_path if finder is not self]
