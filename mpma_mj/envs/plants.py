"""Plants: load, gain, damping and strength of the arms, which may change unannounced."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from mpma_mj.errors import BadOptionError
from mpma_mj.utils.text import did_you_mean
from mpma_mj.utils.validation import Bounds, check_fields

__all__: list[str] = [
    "PLANT_OPTIONS",
    "ActuatorGain",
    "ActuatorStrength",
    "Damping",
    "Payload",
    "Plant",
    "PlantsLike",
    "plants_from",
]

Payload = Annotated[float, Bounds(0.0, 1000.0, hint="in kg")]
ActuatorGain = Annotated[float, Bounds(0.01, 100.0, hint="1 leaves the commands as they are")]
Damping = Annotated[float, Bounds(0.0, 1000.0, hint="in N m s/rad")]
ActuatorStrength = Annotated[float, Bounds(0.01, 100.0, hint="1 leaves the forces as they are")]


@dataclass(frozen=True, kw_only=True)
class Plant:
    """Options of a plant; one that is None is the environment's own.

    Attributes:
        payload: Mass of an iron ball in each hand, kg.
        actuator_gain: Factor on the joint velocities at which the actuators aim.
        damping: Damping that is added to each joint, N m s/rad.
        actuator_strength: Factor on the force limits of the actuators.

    Raises:
        BadOptionError: An option is out of bounds.
    """

    payload: Payload | None = None
    actuator_gain: ActuatorGain | None = None
    damping: Damping | None = None
    actuator_strength: ActuatorStrength | None = None

    def __post_init__(self) -> None:
        """Check every option."""
        check_fields(self)

    def __str__(self) -> str:
        """Return the plant as it is written on the command line."""
        return ",".join(f"{name}={value:g}" for name, value in self.given().items()) or "default"

    def given(self) -> dict[str, float]:
        """Return the options that replace the environment's own, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


PLANT_OPTIONS = tuple(field.name for field in dataclasses.fields(Plant))
"""Names of the options that a plant may have."""

PlantsLike: TypeAlias = Sequence[Plant | Mapping[str, float | None]]
"""Plants, or their options by name."""


def plants_from(given: object) -> tuple[Plant, ...] | None:
    """Return plants; None where none are given.

    Args:
        given: A sequence of plants, or of mappings of their options; or None.

    Raises:
        BadOptionError: There are no plants in it, or a plant has an option that does not exist or
            is out of bounds; names the plant.
    """
    if given is None:
        return None
    if not isinstance(given, Sequence) or isinstance(given, str | bytes) or not given:
        expected = "options of at least one plant, such as [{}, {'payload': 3.0}]"
        raise BadOptionError(option="plants", value=given, expected=expected)
    return tuple(_plant_from(number, plant) for number, plant in enumerate(given))


def _plant_from(number: int, given: Any) -> Plant:
    """Return the plant of this number in the sequence, from 0."""
    if isinstance(given, Plant):
        return given
    name = f"plants[{number}]"
    if not isinstance(given, Mapping):
        raise BadOptionError(
            f"{name} is {given!r}; expected options by name, such as {{'payload': 3.0}}"
        )
    for option in given:
        if option not in PLANT_OPTIONS:
            meant = did_you_mean(str(option), PLANT_OPTIONS)
            remedy = meant or f"expected one or more of {', '.join(PLANT_OPTIONS)}"
            raise BadOptionError(f"{name} has no option '{option}'", remedy=remedy)
    try:
        return Plant(**given)
    except BadOptionError as error:
        # As text, since inside of plants options are written alike everywhere.
        raise BadOptionError(f"{name}: {error}") from None
