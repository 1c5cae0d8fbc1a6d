"""Registration of the environments with Gymnasium."""

from __future__ import annotations

import gymnasium

__all__: list[str] = ["register"]


def register() -> None:
    """Register the environments for `gymnasium.make` and `gymnasium.make_vec`."""
    for name, kind in (("TwoArmImitation-v0", ""), ("TwoArmImitationFlat-v0", "Flat")):
        gymnasium.register(
            id=name,
            entry_point=f"mpma_mj.envs.gym_env:{kind}ImitationEnv",
            vector_entry_point=f"mpma_mj.envs.vector_env:{kind}VectorImitationEnv",
        )
