"""What can be chosen about an environment: one table for every face that it has."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES, SEGMENT_NAMES
from mpma_mj.motions import Motion
from mpma_mj.options import Arms
from mpma_mj.utils.validation import is_boolean, is_integer, is_number

__all__ = ["EnvironmentOptions", "check_seed", "options_from", "seeds_of_batch"]

_MOST_WEIGHT = 1e6
# What acts by forces, which ideal arms do not have.
_OF_MASS = ("gravity_compensation", "payload", "actuator_strength", "perturbation", "collisions")


@dataclass(frozen=True, kw_only=True, eq=False)
class EnvironmentOptions:
    """What is imitated, by which arms, and what makes it hard.

    Attributes:
        motion: The movement, or what `read_motion` takes: "ymca", or a recording's path.
        arms: "physics" for simulated arms, "kinematic" for arms that move ideally.
        model: MJCF file of arms of your own; the package's arms if not given.
        repeats: How often the movement is danced in an episode.
        reference_noise: Standard deviation of the noise on each coordinate of the demonstrated unit
            vectors, which are then made unit vectors again; the paper's 1 % is 0.01.
        seed: Seed of everything random.
        control_timestep: Time between two actions, s; a recording is read at that rate. If not
            given, that of the movement: 0.05 s unless it was read otherwise.
        gravity_compensation: Whether the arms' own weight is carried for them.
        payload: Mass of an iron ball in each hand, kg.
        actuator_strength: Factor on the greatest forces of the actuators.
        locked_joint: A joint that does not turn but stays where an episode begins; none if not
            given.
        collisions: Whether arms and body touch, as the model's geoms say; else they pass through.
        latency: Control steps from an action to its effect; nothing is commanded before.
        observation_noise: Standard deviation of the noise on what is observed of the arms: on
            each coordinate of `posture`, whose vectors are made unit again, on `joint_angles`
            in rad, and on `joint_velocities` in parts of the joints' top speeds.
        perturbation: Rate, 1/s, and size, N, of perturbations: forces of random direction on a
            random hand, each for a tenth of a second, rounded to control steps; those that meet add
            up.
        random_start: Whether an episode starts anywhere in the demonstration, arms in its
            posture and at its speed, instead of at its beginning and at rest.
        termination_distance: Distance of an elbow or wrist from the demonstrated place beyond which
            an episode ends with discount 0, m; never if not given.
        reward_weights: Weights of the reward's terms by name, where they are not 1.
        lookahead: Number of targets that `lookahead` shows, the first being `target`; 0 leaves it
            out.
        phase: Whether to show `phase`: sine and cosine of how far the repetition has come.

    Raises:
        BadOptionError: An option is outside what it may be, or contradicts another.
    """

    motion: Motion | str | Path = field(default="ymca", kw_only=False)
    arms: Arms = "physics"
    model: str | Path | None = None
    repeats: int = 3
    reference_noise: float = 0.01
    seed: int = 0
    control_timestep: float | None = None
    gravity_compensation: bool = False
    payload: float = 0.0
    actuator_strength: float = 1.0
    locked_joint: str | None = None
    collisions: bool = False
    latency: int = 0
    observation_noise: float = 0.0
    perturbation: tuple[float, float] = (0.0, 0.0)
    random_start: bool = False
    termination_distance: float | None = None
    reward_weights: Mapping[str, float] = field(default_factory=dict)
    lookahead: int = 0
    phase: bool = False

    def __post_init__(self) -> None:
        """Check every option, and keep copies of plain types."""
        if not isinstance(self.motion, Motion | str | Path):
            raise BadOptionError(
                f"motion is {self.motion!r}; expected a name, a path, or what read_motion returned"
            )
        if not isinstance(self.arms, str) or self.arms not in get_args(Arms):
            expected = " or ".join(get_args(Arms))
            raise BadOptionError(f"arms is {self.arms!r}; expected {expected}")
        if not isinstance(self.model, str | Path | None):
            raise BadOptionError(f"model is {self.model!r}; expected the path of an MJCF file")
        self._keep_whole("repeats", 1, 1000)
        self._keep_number("reference_noise", 0.0, 1.0, "such as 0.01")
        object.__setattr__(self, "seed", check_seed(self.seed))
        if self.control_timestep is not None:
            self._keep_number("control_timestep", 0.001, 1.0, "in seconds, such as 0.05")
        self._keep_number("payload", 0.0, 1000.0, "in kg")
        self._keep_number("actuator_strength", 0.01, 100.0, "1 leaves the forces as they are")
        self._keep_whole("latency", 0, 100)
        self._keep_number("observation_noise", 0.0, 1.0, "such as 0.01")
        if self.termination_distance is not None:
            self._keep_number("termination_distance", 0.001, 10.0, "in metres, such as 0.3")
        self._keep_whole("lookahead", 0, 1000)
        for name in ("gravity_compensation", "collisions", "random_start", "phase"):
            value = getattr(self, name)
            if not is_boolean(value):
                raise BadOptionError(f"{name} is {value!r}; expected True or False")
            object.__setattr__(self, name, bool(value))
        named = isinstance(self.locked_joint, str) and self.locked_joint in JOINT_NAMES
        if self.locked_joint is not None and not named:
            raise BadOptionError(
                f"locked_joint is {self.locked_joint!r}; expected one of {', '.join(JOINT_NAMES)}"
            )
        self._keep_perturbation()
        self._keep_weights()
        self._check_arms_have_mass()

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Which joints turn, shape (8,)."""
        return np.array([name != self.locked_joint for name in JOINT_NAMES])

    @property
    def perturbed(self) -> bool:
        """Whether there are pushes."""
        return min(self.perturbation) > 0.0

    def _keep_whole(self, name: str, low: int, high: int) -> None:
        value = getattr(self, name)
        if not (is_integer(value) and low <= int(value) <= high):
            raise BadOptionError(
                f"{name} is {value!r}; expected a whole number from {low} to {high}"
            )
        object.__setattr__(self, name, int(value))

    def _keep_number(self, name: str, low: float, high: float, hint: str) -> None:
        value = getattr(self, name)
        if not (is_number(value) and low <= float(value) <= high):
            raise BadOptionError(f"{name} is {value!r}; expected {low:g} to {high:g}, {hint}")
        object.__setattr__(self, name, float(value))

    def _keep_perturbation(self) -> None:
        given = self.perturbation
        pair = isinstance(given, tuple | list | np.ndarray) and len(given) == 2
        rate, size = given if pair else (math.nan, math.nan)
        numbers = is_number(rate) and is_number(size)
        if not (numbers and 0.0 <= rate <= 100.0 and 0.0 <= size <= 10_000.0):
            raise BadOptionError(
                f"perturbation is {given!r}; expected rate (0 to 100 a second) and size (0 to 10000"
                " N), such as (0.5, 30)"
            )
        object.__setattr__(self, "perturbation", (float(rate), float(size)))

    def _keep_weights(self) -> None:
        weights = self.reward_weights
        if not isinstance(weights, Mapping) or not weights.keys() <= set(SEGMENT_NAMES):
            raise BadOptionError(
                f"reward_weights is {weights!r}; expected a weight for some of"
                f" {', '.join(SEGMENT_NAMES)}"
            )
        for name, weight in weights.items():
            if not (is_number(weight) and 0.0 <= float(weight) <= _MOST_WEIGHT):
                raise BadOptionError(
                    f"reward_weights has {weight!r} for {name}; expected 0 to {_MOST_WEIGHT:g}"
                )
        if len(weights) == len(SEGMENT_NAMES) and not any(weights.values()):
            raise BadOptionError("reward_weights are all 0; expected at least one above 0")
        copy = {name: float(weight) for name, weight in weights.items()}
        object.__setattr__(self, "reward_weights", copy)

    def _check_arms_have_mass(self) -> None:
        if self.arms == "physics":
            return
        for option in fields(self):
            if option.name in _OF_MASS and getattr(self, option.name) != option.default:
                raise BadOptionError(
                    f"{option.name} is {getattr(self, option.name)!r}, but ideal arms have no mass;"
                    " leave it out, or take arms='physics'"
                )


def options_from(*motion: Any, **given: Any) -> EnvironmentOptions:
    """Return options from what a user wrote.

    Args:
        *motion: The movement, if it was not given by name.
        **given: The fields of `EnvironmentOptions`.

    Raises:
        BadOptionError: There is no option of a name, or its value is outside what it may be.
    """
    if len(motion) > 1:
        raise BadOptionError(
            f"{motion[1]!r} has no name; only the movement goes without, as in"
            ' load("ymca", arms="physics")'
        )
    if motion and "motion" in given:
        raise BadOptionError("motion is given twice; leave one out")
    known = [option.name for option in fields(EnvironmentOptions)]
    for name in given:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            guess = f"; did you mean {close[0]}?" if close else f"; expected {', '.join(known)}"
            raise BadOptionError(f"no option '{name}'{guess}")
    return EnvironmentOptions(*motion, **given)


def check_seed(seed: object) -> int:
    """Return a seed as Python's own whole number.

    Raises:
        BadOptionError: It is none.
    """
    if not (is_integer(seed) and int(seed) >= 0):
        raise BadOptionError(f"seed is {seed!r}; expected a whole number from 0 up")
    return int(seed)


def seeds_of_batch(seed: object, count: int) -> list[int | None]:
    """Return a seed for each of many environments.

    Args:
        seed: Seed of the first, the others' follow it; or one for each, None where there is none.
        count: Number of environments.

    Raises:
        BadOptionError: A seed is no whole number from 0 up, or there are not so many of them.
    """
    if isinstance(seed, np.ndarray):
        seed = seed.tolist()
    if not isinstance(seed, Sequence) or isinstance(seed, str | bytes):
        first = check_seed(seed)
        return [first + member for member in range(count)]
    if len(seed) != count:
        raise BadOptionError(f"seed has {len(seed)} entries; expected {count}")
    return [None if own is None else check_seed(own) for own in seed]
