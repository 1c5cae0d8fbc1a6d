"""Imitation of motion-capture recordings by two simulated arms.

A MuJoCo environment in which two arms imitate recorded motions, and agents that learn to control
them, such as the Multiple Paired Models Architecture (MPMA) of Tidemann & Öztürk (2008).

    env = mpma_mj.load("ymca", arms="physics", seed=0)      # a dm_env.Environment
    motion = mpma_mj.read_motion("dance.tsv")
"""

import gymnasium
import lazy_loader

from mpma_mj.envs.gl import choose_backend, defer_opengl

# Names are imported when they are used first, so that `import mpma_mj` stays fast.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

choose_backend()  # before MuJoCo is imported, which reads the choice on import
defer_opengl()

# Gymnasium imports this package to find its environments.
for _kind in ("", "Flat"):
    gymnasium.register(
        id=f"TwoArmImitation{_kind}-v0",
        entry_point=f"mpma_mj.envs.gym_env:{_kind}ImitationEnv",
        vector_entry_point=f"mpma_mj.envs.vector_env:{_kind}VectorImitationEnv",
    )
