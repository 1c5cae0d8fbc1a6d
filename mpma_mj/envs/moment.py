"""Moments of an episode, to which an environment can go back to the bit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

__all__: list[str] = ["EnvironmentMoment"]

_STATE = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)


@dataclass(frozen=True, eq=False)
class EnvironmentMoment:
    """Moment of an episode, from which it can go on to the bit.

    Attributes:
        physics: Time, joint state and activations, as MuJoCo orders them.
        task: Attributes of the task; arrays are replaced and never changed, the list of postures
            grows.
        postures: Number of postures so far.
    """

    physics: NDArray[np.float64]
    task: dict[str, Any]
    postures: int

    @classmethod
    def of(cls, env: control.Environment) -> EnvironmentMoment:
        """Return the present moment."""
        model, data = env.physics.model.ptr, env.physics.data.ptr
        state = np.empty(mujoco.mj_stateSize(model, _STATE))
        mujoco.mj_getState(model, data, state, _STATE)
        return cls(state, *env.task.save_moment())

    def restore(self, env: control.Environment) -> None:
        """Go back to this moment of the latest episode; what is set by hand stays.

        Moments after it cannot be restored any more.
        """
        env.reset()  # else an environment whose episode is over would begin the next one
        self.pose(env.physics.model.ptr, env.physics.data.ptr)
        env.task.restore_moment(env.physics, self.task, self.postures)

    def pose(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Place arms in this moment."""
        mujoco.mj_setState(model, data, self.physics, _STATE)
        mujoco.mj_kinematics(model, data)
