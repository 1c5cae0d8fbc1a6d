"""Disturbances under which trained agents are evaluated, each at several levels."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions import Motion, read_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.transforms import at_rate, mirrored, with_context_of

__all__ = ["DISTURBANCES", "Disturbance", "Level"]

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
        ("none", *JOINT_NAMES[:4]),
        _option("locked_joint", lambda level: None if level == "none" else level),
        ("none", *JOINT_NAMES),
    ),
    Disturbance("unseen", "unseen motion", (), _unseen, ()),
)

DISTURBANCES = {disturbance.name: disturbance for disturbance in _ALL}
"""All disturbances by name."""
