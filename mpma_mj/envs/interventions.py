"""Changes of an environment while an episode runs, and moments to which it can go back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import mujoco
import numpy as np
from dm_control.rl import control
from numpy.typing import NDArray

from mpma_mj.envs.plants import ActuatorGain, Payload
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import Bounds, check_fields

if TYPE_CHECKING:
    from mpma_mj.envs.physics import PhysicsArms

__all__: list[str] = ["LONGEST_LATENCY", "EnvironmentMoment", "Intervention"]

LONGEST_LATENCY = 10
"""Longest latency that an intervention can set, control steps (choice)."""


@dataclass(frozen=True, kw_only=True)
class Intervention:
    """Values that are set by hand, in place of those that the options set or draw.

    Attributes:
        payload: Mass of an iron ball in each hand, kg.
        actuator_gain: Factor on the joint velocities at which the actuators aim.
        plant: Index of the plant that is on; payload and gain, where given, replace its own.
        latency: Control steps from an action to its effect.

    Raises:
        BadOptionError: An option is out of bounds.
    """

    payload: Payload | None = None
    actuator_gain: ActuatorGain | None = None
    plant: Annotated[int | None, Bounds(0, 1_000_000)] = None
    latency: Annotated[int | None, Bounds(0, LONGEST_LATENCY)] = None

    def __post_init__(self) -> None:
        """Check every option."""
        check_fields(self)

    def check(self, physics: PhysicsArms, plants: int) -> None:
        """Check that arms can have these values, given the number of plants.

        Raises:
            BadOptionError: There is no such plant, or the model has no hands for a payload.
        """
        if self.plant is not None and self.plant >= plants:
            expected = f"an index below {plants}" if plants else "None: there are no plants"
            raise BadOptionError(option="plant", value=self.plant, expected=expected)
        if self.payload and not physics.compiled_plants.compiler.has_balls:
            expected = "0, since the model has no bodies left_hand and right_hand to carry it"
            raise BadOptionError(option="payload", value=self.payload, expected=expected)

    def plant_values(self, plant: dict[str, float]) -> dict[str, float]:
        """Return the values of a plant with those that are set in their place."""
        given = {"payload": self.payload, "actuator_gain": self.actuator_gain}
        return plant | {name: value for name, value in given.items() if value is not None}


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


_STATE = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
