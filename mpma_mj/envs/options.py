"""Options of an environment: its arms, its difficulty, its observations."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np

from mpma_mj.envs.option_checks import (
    checked_dwell,
    checked_perturbation,
    checked_robot,
    checked_weights,
)
from mpma_mj.envs.plants import (
    PLANT_OPTIONS,
    ActuatorGain,
    ActuatorStrength,
    Damping,
    Payload,
    Plant,
    plants_from,
)
from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.options import TWO_ARM, Arms
from mpma_mj.utils.text import did_you_mean
from mpma_mj.utils.validation import Bounds, Range, check_fields, is_integer

__all__: list[str] = [
    "DRAWN_OPTIONS",
    "FIELDS_OF_PLANTS",
    "MASS_OPTIONS",
    "EnvironmentOptions",
    "check_names",
    "check_seed",
    "options_among",
    "seeds_of_batch",
]

Noise = Annotated[float, Bounds(0.0, 1.0, hint="such as 0.01")]
MASS_OPTIONS = (
    *("gravity_compensation", "payload", "actuator_strength", "damping"),
    *("perturbation", "collisions"),
)
"""Options that act by forces, which ideal arms do not have."""
DRAWN_OPTIONS = (*PLANT_OPTIONS, "observation_noise", "reference_noise")
"""Options that are drawn for each episode where they are ranges."""
FIELDS_OF_PLANTS = ("plants", "switch_every", "epochs_per_plant")
"""Options that select the plants that may be on, and when."""


@dataclass(frozen=True, kw_only=True)
class EnvironmentOptions:
    """Options of an environment, apart from its motion and its seed.

    `load(motion, seed=seed, **vars(options))` returns the environment with these options. Those of
    `DRAWN_OPTIONS` may be ranges of two numbers, from which one is drawn for each episode. With
    equal ends the episodes are those of that number, as each option has a random stream of its own.

    Attributes:
        arms: "physics" for simulated arms, "kinematic" for arms that move ideally.
        robot: Name of a robot, such as "h1"; or the path of a robot file, or of an MJCF file with
            the joints of "two_arm". See docs/guides/robots.md.
        repeats: Number of repetitions of the motion in an episode.
        reference_noise: Standard deviation of the noise on each coordinate of the demonstrated unit
            vectors, which are normalised again; the paper's 1 % is 0.01.
        control_timestep: Time between two actions, s; a recording is resampled to that rate. If not
            given, that of the motion: 0.05 s unless it was read at another rate.
        gravity_compensation: Whether the weight of the arms is compensated.
        payload: Mass of an iron ball in each hand, kg.
        actuator_strength: Factor on the force limits of the actuators.
        actuator_gain: Factor on the joint velocities at which the actuators aim.
        damping: Damping that is added to each joint, N m s/rad.
        locked_joint: Joint that is held fixed where an episode begins; none if not given.
        collisions: Whether arms and body collide, as their geoms define; else they pass through.
        latency: Control steps from an action to its effect; no motion is commanded before. A range
            of them, lowest and highest, is drawn from uniformly for each episode.
        latency_every: Lowest and highest time after which the latency jumps to another of its
            range within an episode, s; drawn uniformly. If not given, an episode has one latency.
        observation_noise: Standard deviation of the noise on the observed state of the arms: on
            each coordinate of `posture`, whose vectors are normalised again, on `joint_angles`
            in rad, and on `joint_velocities` as a fraction of the joints' top speeds.
        perturbation: Rate, 1/s, and size, N, of random pushes: forces of random direction on a
            random hand, each for a tenth of a second, rounded to control steps; simultaneous ones
            add up.
        random_start: Whether an episode starts anywhere in the demonstration, with the arms in its
            posture and at its velocity, instead of at its beginning and at rest; "adaptive" for
            more often where past episodes of this environment missed reward.
        termination_distance: Distance of an elbow or wrist from the demonstrated position beyond
            which an episode ends with discount 0, m; never if not given.
        reward_weights: Weights of the reward's terms by name, where they are not 1.
        lookahead: Number of targets in the observation `lookahead`, the first being `target`; 0
            leaves it out.
        phase: Whether to observe `phase`: sine and cosine of the progress of the repetition.
        error_observation: Whether to observe `move`: the joints' way to the target as a multiple of
            their largest move in a step.
        plants: Plants, one of which is on at a time, unobserved: for each its options of `Plant`,
            in place of those above; a single plant, with those above, if not given.
        switch_every: Lowest and highest time after which the plant changes to another one within
            an episode, s; drawn uniformly. If not given, each episode has one plant.
        epochs_per_plant: Number of episodes with a plant before the next one follows, without
            `switch_every`.

    Raises:
        BadOptionError: An option is out of bounds, or contradicts another.
    """

    arms: Arms = "physics"
    robot: str = TWO_ARM
    repeats: Annotated[int, Bounds(1, 1000)] = 3
    reference_noise: Noise | Range = 0.01
    control_timestep: Annotated[
        float | None, Bounds(0.001, 1.0, hint="in seconds, such as 0.05")
    ] = None
    gravity_compensation: bool = False
    payload: Payload | Range = 0.0
    actuator_strength: ActuatorStrength | Range = 1.0
    actuator_gain: ActuatorGain | Range = 1.0
    damping: Damping | Range = 0.0
    locked_joint: str | None = None
    collisions: bool = False
    latency: Annotated[int, Bounds(0, 100)] | tuple[int, int] = 0
    latency_every: tuple[float, float] | None = None
    observation_noise: Noise | Range = 0.0
    perturbation: tuple[float, float] = (0.0, 0.0)
    random_start: bool | Literal["adaptive"] = False
    termination_distance: Annotated[
        float | None, Bounds(0.001, 10.0, hint="in metres, such as 0.3")
    ] = None
    reward_weights: Mapping[str, float] = field(default_factory=dict, hash=False)
    lookahead: Annotated[int, Bounds(0, 1000)] = 0
    phase: bool = False
    error_observation: bool = False
    plants: tuple[Plant, ...] | None = None
    switch_every: tuple[float, float] | None = None
    epochs_per_plant: Annotated[int, Bounds(1, 1_000_000)] = 3

    def __post_init__(self) -> None:
        """Check every option, and keep copies of plain types."""
        check_fields(self)
        object.__setattr__(self, "robot", checked_robot(self.robot))
        joint: object = self.locked_joint
        own = self.robot != TWO_ARM or joint in JOINT_NAMES  # others are checked with the model
        if not (joint is None or (isinstance(joint, str) and own)):
            expected = f"one of {', '.join(JOINT_NAMES)}"
            raise BadOptionError(option="locked_joint", value=joint, expected=expected)
        object.__setattr__(self, "perturbation", checked_perturbation(self.perturbation))
        object.__setattr__(self, "reward_weights", checked_weights(self.reward_weights))
        for option in dataclasses.fields(self) if self.arms == "kinematic" else ():
            value = getattr(self, option.name)
            if option.name in MASS_OPTIONS and value != option.default:
                remedy = f"leave {{{option.name}}} out, or choose {{arms=physics}}"
                remedy = f"ideal arms have no mass: {remedy}"
                raise BadOptionError(option=option.name, value=value, remedy=remedy)
        self._check_latency()
        object.__setattr__(self, "plants", plants_from(self.plants))
        for name in PLANT_OPTIONS if self.plants is not None else ():
            if name in self.ranges:
                remedy = "plants have one each: give one number, or leave {plants} out"
                raise BadOptionError(option=name, value=self.ranges[name], remedy=remedy)
        if self.switch_every is not None:
            dwell = checked_dwell("switch_every", self.switch_every)
            object.__setattr__(self, "switch_every", dwell)
        self._check_plants()

    @property
    def longest_latency(self) -> int:
        """Longest latency that there may be, control steps."""
        return self.latency if isinstance(self.latency, int) else self.latency[1]

    @property
    def ranges(self) -> dict[str, Range]:
        """Ranges from which options are drawn for each episode, by name."""
        given = ((name, getattr(self, name)) for name in DRAWN_OPTIONS)
        return {name: value for name, value in given if isinstance(value, tuple)}

    @property
    def perturbed(self) -> bool:
        """Whether there are perturbations."""
        return min(self.perturbation) > 0.0

    def of_plants(self) -> tuple[EnvironmentOptions, ...]:
        """Return the options with those of each plant; these alone where there are no plants."""
        if self.plants is None:
            return (self,)
        return tuple(self._with_plant(number) for number in range(len(self.plants)))

    def _with_plant(self, number: int) -> EnvironmentOptions:
        """Return the options with those of a plant, given its index."""
        assert self.plants is not None
        changes: dict[str, Any] = {option.name: option.default for option in _fields_of_plants()}
        changes |= self.plants[number].given()
        try:
            return dataclasses.replace(self, **changes)
        except BadOptionError as error:
            raise error.with_context(f"plants[{number}]") from None

    def _check_latency(self) -> None:
        """Check latency and times between its jumps, and keep plain copies."""
        if self.latency_every is None:
            return
        dwell = checked_dwell("latency_every", self.latency_every)
        object.__setattr__(self, "latency_every", dwell)
        if isinstance(self.latency, int) or self.latency[0] == self.latency[1]:
            remedy = "that needs a range: give {latency} two numbers that differ, or leave it out"
            raise BadOptionError(option="latency_every", value=dwell, remedy=remedy)

    def _check_plants(self) -> None:
        """Check that the arms can be all plants, and that no option of plants is without them."""
        if self.plants is None:
            for option in _fields_of_plants():
                value = getattr(self, option.name)
                if value != option.default:
                    remedy = f"give {{plants}} too, or leave {{{option.name}}} out"
                    raise BadOptionError(option=option.name, value=value, remedy=remedy)
        elif self.switch_every is not None and len(self.plants) == 1:
            remedy = "that needs two plants or more: add some to {plants}, or leave it out"
            raise BadOptionError(option="switch_every", value=self.switch_every, remedy=remedy)
        else:
            self._check_differences(self.of_plants())

    def _check_differences(self, plants: tuple[EnvironmentOptions, ...]) -> None:
        """Check that no two plants are the same; those of the environment included."""
        for number, plant in enumerate(plants):
            if plant in plants[:number]:
                problem = f"plants[{plants.index(plant)}] and plants[{number}] are the same"
                remedy = "leave one out of {plants}; options not given are the environment's own"
                raise BadOptionError(problem, remedy=remedy)


_NAMES = [option.name for option in dataclasses.fields(EnvironmentOptions)]
_NO_OPTIONS = ("self", "__class__", "options")  # among the names in a method


def _fields_of_plants() -> tuple[dataclasses.Field[Any], ...]:
    """Return the fields that select the plants that may be on, and when."""
    fields = dataclasses.fields(EnvironmentOptions)
    return tuple(option for option in fields if option.name in FIELDS_OF_PLANTS)


def check_names(given: Iterable[str], known: Collection[str]) -> None:
    """Check that options exist, given their names and those of all.

    Raises:
        BadOptionError: One does not; names it, and the most similar one or all.
    """
    for name in given:
        if name not in known:
            expected = ", ".join(f"{{{option}}}" for option in known)
            remedy = did_you_mean(name, known, "{{{}}}") or f"expected {expected}"
            raise BadOptionError(f"no option '{name}'", remedy=remedy)


def options_among(arguments: Mapping[str, Any]) -> EnvironmentOptions:
    """Return the options among the arguments of a function.

    Args:
        arguments: The function's `locals()` where it begins, with keyword arguments that it does
            not name in `options`; `reward_weights` may be None.

    Raises:
        BadOptionError: An option does not exist, or is out of bounds.
    """
    named = {name: arguments[name] for name in arguments if name not in _NO_OPTIONS}
    check_names(arguments["options"], dict.fromkeys((*named, *_NAMES)))
    given = named | arguments["options"]
    if given.get("reward_weights", {}) is None:
        del given["reward_weights"]
    return EnvironmentOptions(**{name: given[name] for name in _NAMES if name in given})


def check_seed(seed: object, name: str = "seed") -> int:
    """Return a seed, or the number of an episode by its name, as a plain integer.

    Raises:
        BadOptionError: It is negative or no integer.
    """
    if not (is_integer(seed) and int(seed) >= 0):
        raise BadOptionError(option=name, value=seed, expected="a whole number from 0 up")
    return int(seed)


def seeds_of_batch(seed: object, count: int) -> list[int | None]:
    """Return one seed for each environment of a batch.

    Args:
        seed: Seed of the first, the others' follow it; or one for each, None where there is none.
        count: Number of environments.

    Raises:
        BadOptionError: A seed is negative or no integer, or their number is another.
    """
    if isinstance(seed, np.ndarray):
        seed = seed.tolist()
    if not isinstance(seed, Sequence) or isinstance(seed, str | bytes):
        first = check_seed(seed)
        return [first + run for run in range(count)]
    if len(seed) != count:
        raise BadOptionError(f"seed has {len(seed)} entries; expected {count}")
    return [None if own is None else check_seed(own) for own in seed]
