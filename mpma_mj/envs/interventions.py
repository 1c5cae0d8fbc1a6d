"""Interventions: changes of an environment while an episode runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from mpma_mj.envs.plants import ActuatorGain, Payload
from mpma_mj.errors import BadOptionError
from mpma_mj.utils.validation import Bounds, check_fields

if TYPE_CHECKING:
    from mpma_mj.envs.physics import PhysicsArms

__all__: list[str] = ["LONGEST_LATENCY", "Intervention"]

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
