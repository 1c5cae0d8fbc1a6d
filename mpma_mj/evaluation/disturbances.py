"""Disturbances under which trained agents are evaluated: conditions at several levels of each."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpma_mj.envs.load import prepare
from mpma_mj.envs.options import FIELDS_OF_PLANTS, MASS_OPTIONS, EnvironmentOptions
from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.evaluation.evaluate import EvalCondition
from mpma_mj.motions import BUILT_IN, Motion, read_motion
from mpma_mj.motions.built_in import built_in, file_stem
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.transforms import at_rate, mirrored, with_context_of
from mpma_mj.options import Arms
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import did_you_mean

__all__ = [
    "DISTURBANCES",
    "Disturbance",
    "DisturbanceLevel",
    "Level",
    "disturbance_levels",
    "shown",
]

Level = float | str
"""A number, or a name."""

_PUSHES_PER_SECOND = 1.0


@dataclass(frozen=True)
class Disturbance:
    """A change of motion or environment, at several levels.

    Attributes:
        name: Name, on the command line and in files.
        title: Title, with the unit of the levels.
        levels: Default levels (choice); those of unseen motions depend on the motions learned.
        change: Function of a motion and a level that returns the motion and the environment's
            options at that level.
        names: Names of all levels, empty where any is allowed; levels are numbers if not given.
        needs_mass: Whether ideal arms, which have no mass, cannot have it.
    """

    name: str
    title: str
    levels: tuple[Level, ...]
    change: Callable[[Motion, Any], tuple[Motion, dict[str, Any]]]
    names: tuple[str, ...] | None = None
    needs_mass: bool = False

    @property
    def is_ordered(self) -> bool:
        """Whether levels are numbers."""
        return self.names is None

    def read_level(self, text: str) -> Level:
        """Return the level that a text stands for.

        Raises:
            BadOptionError: It is no level of this disturbance.
        """
        if self.names is None:
            with contextlib.suppress(ValueError):
                if math.isfinite(level := float(text)):
                    return level
        elif not self.names or text in self.names:
            return text
        expected = "numbers" if self.names is None else f"some of {', '.join(self.names)}"
        raise BadOptionError(f"{self.name} has no level '{text}'; expected {expected}")


def _option(name: str, value: Callable[[Any], Any] = float) -> Callable[..., Any]:
    """Return the change that sets one option of the environment."""

    def change(motion: Motion, level: Any) -> tuple[Motion, dict[str, Any]]:
        return motion, {name: value(level)}

    return change


def _late(motion: Motion, level: float) -> tuple[Motion, dict[str, Any]]:
    steps = int(level) if level.is_integer() else level  # for the option to refuse
    return motion, {"latency": steps, "latency_every": None}


def _at_tempo(motion: Motion, tempo: float) -> tuple[Motion, dict[str, Any]]:
    ReadingOptions(tempo=tempo).check()
    return at_rate(motion, motion.rate, tempo), {}


def _mirrored(motion: Motion, level: str) -> tuple[Motion, dict[str, Any]]:
    return (mirrored(motion) if level == "yes" else motion), {}


def _unseen(motion: Motion, source: str) -> tuple[Motion, dict[str, Any]]:
    return with_context_of(read_motion(source, rate=motion.rate), motion), {}


_ALL = (
    Disturbance(
        "payload",
        "payload in each hand, kg",
        (0.0, 0.5, 1.0, 2.0, 3.0),
        _option("payload"),
        needs_mass=True,
    ),
    Disturbance(
        "strength",
        "strength, share of the whole",
        (1.0, 0.7, 0.5, 0.3, 0.2, 0.1),
        _option("actuator_strength"),
        needs_mass=True,
    ),
    Disturbance(
        "gravity",
        "gravity",
        ("on", "off"),
        _option("gravity_compensation", lambda level: level == "off"),
        ("on", "off"),
        needs_mass=True,
    ),
    Disturbance("latency", "latency, steps", (0.0, 1.0, 2.0, 3.0), _late),
    Disturbance(
        "noise",
        "observation noise, %",
        (0.0, 1.0, 2.0, 5.0, 10.0),
        _option("observation_noise", lambda percent: percent / 100.0),
    ),
    Disturbance(
        "pushes",
        "pushes once a second, N",
        (0.0, 10.0, 20.0, 50.0, 100.0),
        _option("perturbation", lambda size: (_PUSHES_PER_SECOND if size else 0.0, size)),
        needs_mass=True,
    ),
    Disturbance("tempo", "tempo", (0.5, 0.75, 1.0, 1.25, 1.5, 2.0), _at_tempo),
    Disturbance("mirrored", "mirrored motion", ("no", "yes"), _mirrored, ("no", "yes")),
    Disturbance(
        "locked",
        "locked joint",
        ("none",),  # and the joints of the robot's left arm
        _option("locked_joint", lambda level: None if level == "none" else level),
        ("none",),
    ),
    Disturbance("unseen", "unseen motion", (), _unseen, ()),
)

DISTURBANCES = {disturbance.name: disturbance for disturbance in _ALL}
"""All disturbances by name."""

_DEFAULTS = vars(EnvironmentOptions())
_SYNTHETIC_MOTIONS = 8  # by default (choice)


@dataclass(frozen=True, eq=False)
class DisturbanceLevel:
    """A level of a disturbance.

    Attributes:
        disturbance: Name of the disturbance.
        level: The level.
        condition: The condition at that level.
    """

    disturbance: str
    level: Level
    condition: EvalCondition


def shown(level: Level) -> str:
    """Return a level as text."""
    return level if isinstance(level, str) else f"{level:g}"


def disturbance_levels(
    config: RunConfig,
    motion: Motion,
    *,
    disturbances: Sequence[str] = (),
    levels: Sequence[str] = (),
    motions: Sequence[str] = (),
    arms: Arms = "physics",
) -> tuple[DisturbanceLevel, ...]:
    """Return the levels of disturbances with their conditions.

    Args:
        config: Config of the training.
        motion: Motion of the training.
        disturbances: Names of disturbances; all that the arms can have if not given.
        levels: Levels of a single disturbance; the default ones if not given.
        motions: Unseen motions, in place of synthetic ones.
        arms: Kind of arms; they are without plants.

    Raises:
        MpmaError: There is no such disturbance, a level is out of bounds, or an unseen motion
            cannot be read, or was learned.
    """
    possible = (d.name for d in DISTURBANCES.values() if arms == "physics" or not d.needs_mass)
    robot = read_robot(config.env.robot)
    if arms == "physics" and robot.unknown:
        problem = f"physical values of {robot.name} are unknown: {', '.join(robot.unknown)}"
        raise BadOptionError(problem, remedy="choose {arms=kinematic}")
    joints = robot.joints
    chosen = [_disturbance(name, joints) for name in dict.fromkeys(disturbances or possible)]
    if levels and len(chosen) != 1:
        problem = "levels are given, but they belong to a single disturbance"
        raise BadOptionError(problem, remedy="name it with {disturbances}")
    if motions and (levels or "unseen" not in (disturbance.name for disturbance in chosen)):
        problem = "unseen motions are given, but not evaluated"
        remedy = "leave {motions} out, or choose {disturbances=unseen} without {levels}"
        raise BadOptionError(problem, remedy=remedy)
    home = {"arms": arms} | {name: _DEFAULTS[name] for name in FIELDS_OF_PLANTS}
    if arms == "kinematic":
        home |= {name: _DEFAULTS[name] for name in MASS_OPTIONS}
    undisturbed = EvalCondition("undisturbed", motion, home)
    found = []
    for disturbance in chosen:
        given: Sequence[Level] = levels or disturbance.levels
        if disturbance.name == "unseen" and not levels:
            given = motions or _unseen_motions(config)
        read = (disturbance.read_level(x) if isinstance(x, str) else x for x in given)
        found += [
            DisturbanceLevel(
                disturbance.name, level, _condition(disturbance, level, config, undisturbed)
            )
            for level in dict.fromkeys(read)
        ]
    return tuple(found)


def _disturbance(name: str, joints: Sequence[str]) -> Disturbance:
    """Return a disturbance by its name, for a robot with joints of these names."""
    if name not in DISTURBANCES:
        raise BadOptionError(
            f"no disturbance '{name}'; expected one or more of {', '.join(DISTURBANCES)}",
            remedy=did_you_mean(name, DISTURBANCES),
        )
    disturbance = DISTURBANCES[name]
    if name == "locked":
        levels = ("none", *joints)
        return dataclasses.replace(disturbance, levels=levels[:5], names=levels)
    return disturbance


def _unseen_motions(config: RunConfig) -> Sequence[str]:
    """Return synthetic motions that are not among those of the training."""
    if "synthetic" in config.motions:
        raise BadOptionError(
            "all synthetic motions were learned",
            remedy="name others with {motions}, or choose {disturbances} without unseen",
        )
    synthetic = (name for name in BUILT_IN if name.startswith("synthetic-"))
    unseen = (name for name in synthetic if name not in config.motions)
    return list(itertools.islice(unseen, _SYNTHETIC_MOTIONS))


def _condition(
    disturbance: Disturbance, level: Level, config: RunConfig, undisturbed: EvalCondition
) -> EvalCondition:
    """Return the condition of a level, with a motion that the arms can follow."""
    name = f"{disturbance.name} {shown(level)}"
    unseen = disturbance.name == "unseen"
    if unseen and _identity(str(level)) in map(_identity, config.motions):
        raise BadOptionError(f"{level} was learned", remedy="name other {motions}")
    try:
        motion, changed = disturbance.change(undisturbed.motion, level)
        own = dataclasses.replace(config.env, **undisturbed.options)
        same = all(value == getattr(own, option) for option, value in changed.items())
        if motion is undisturbed.motion and same:
            return undisturbed
        options = {**undisturbed.options, **changed}
        motion, _, _ = prepare(motion, dataclasses.replace(config.env, **options))
    except BadOptionError as error:
        # As text, since options of environments and motions are none of an evaluation.
        raise BadOptionError(f"{name}: {error}") from None
    except MotionFileError as error:
        # Its remedy, an option of reading, is given to `mpma motion`.
        writes = "mpma motion, with that and {out=FILE.npz}, writes such a motion"
        error.remedy = f"{error.remedy}: {writes}" if error.remedy else writes
        raise
    return EvalCondition(name, motion, options)


def _identity(source: str) -> object:
    """Return what all names of one motion have in common."""
    return file_stem(source) if built_in(source) else Path(source).resolve()
