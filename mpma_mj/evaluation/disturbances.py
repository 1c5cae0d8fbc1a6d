"""What a trained agent may meet that it has not learned with, each at several levels."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.motions import Motion, read_motion
from mpma_mj.motions.motion_file import at_rate
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.variants import mirrored, with_music_of

__all__ = ["DISTURBANCES", "Disturbance", "Level"]

Level = float | str
"""A number, or a name."""

_PUSHES_PER_SECOND = 1.0


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """One thing that makes a condition other than that of training.

    Attributes:
        name: What it is called, in files too.
        title: What it is, with the unit of its levels.
        levels: Usual levels (choice); of dances never seen none, as that depends on those seen.
        change: Takes the movement and a level to the movement and the environment's options there.
        names: What its levels may be; any number if not given. Dances may be anything.
    """

    name: str
    title: str
    levels: tuple[Level, ...]
    change: Callable[[Motion, Any], tuple[Motion, dict[str, Any]]]
    names: tuple[str, ...] | None = None

    @property
    def is_ordered(self) -> bool:
        """Whether levels are numbers."""
        return self.names is None

    def read_level(self, text: str) -> Level:
        """Return the level that a text stands for.

        Raises:
            BadOptionError: It is no level of this disturbance.
        """
        if self.names == ():
            return text
        if self.names is not None:
            if text not in self.names:
                raise BadOptionError(
                    f"{self.name} has no level '{text}'; expected some of {', '.join(self.names)}"
                )
            return text
        try:
            level = float(text)
        except ValueError:
            level = math.nan
        if not math.isfinite(level):
            raise BadOptionError(f"{self.name} has no level '{text}'; expected numbers")
        return level


def _option(name: str, value: Callable[[Any], Any] = float) -> Callable[..., Any]:
    """Return the change that sets one option of the environment."""

    def change(motion: Motion, level: Any) -> tuple[Motion, dict[str, Any]]:
        return motion, {name: value(level)}

    return change


def _late(motion: Motion, level: float) -> tuple[Motion, dict[str, Any]]:
    return motion, {"latency": _whole(level), "latency_every": None}


def _whole(level: float) -> float | int:
    """Return a whole number as such; another is for the option to refuse."""
    return int(level) if level.is_integer() else level


def _pushes(size: float) -> tuple[float, float]:
    return (_PUSHES_PER_SECOND if size else 0.0, size)


def _at_tempo(motion: Motion, tempo: float) -> tuple[Motion, dict[str, Any]]:
    ReadingOptions(tempo=tempo).check()
    return at_rate(motion, motion.rate, tempo), {}


def _mirrored(motion: Motion, level: str) -> tuple[Motion, dict[str, Any]]:
    return (mirrored(motion) if level == "yes" else motion), {}


def _unseen(motion: Motion, source: str) -> tuple[Motion, dict[str, Any]]:
    return with_music_of(read_motion(source, rate=motion.rate), motion), {}


_ALL = (
    Disturbance(
        name="payload",
        title="payload in each hand, kg",
        levels=(0.0, 0.5, 1.0, 2.0, 3.0),
        change=_option("payload"),
    ),
    Disturbance(
        name="strength",
        title="strength, share of the whole",
        levels=(1.0, 0.7, 0.5, 0.3, 0.2, 0.1),
        change=_option("actuator_strength"),
    ),
    Disturbance(
        name="gravity",
        title="gravity",
        levels=("on", "off"),
        change=_option("gravity_compensation", lambda level: level == "off"),
        names=("on", "off"),
    ),
    Disturbance(
        name="latency",
        title="latency, steps",
        levels=(0.0, 1.0, 2.0, 3.0),
        change=_late,
    ),
    Disturbance(
        name="noise",
        title="observation noise, %",
        levels=(0.0, 1.0, 2.0, 5.0, 10.0),
        change=_option("observation_noise", lambda percent: percent / 100.0),
    ),
    Disturbance(
        name="pushes",
        title="pushes once a second, N",
        levels=(0.0, 10.0, 20.0, 50.0, 100.0),
        change=_option("perturbation", _pushes),
    ),
    Disturbance(
        name="tempo",
        title="tempo",
        levels=(0.5, 0.75, 1.0, 1.25, 1.5, 2.0),
        change=_at_tempo,
    ),
    Disturbance(
        name="mirrored",
        title="mirrored dance",
        levels=("no", "yes"),
        change=_mirrored,
        names=("no", "yes"),
    ),
    Disturbance(
        name="locked",
        title="locked joint",
        levels=("none", *JOINT_NAMES[:4]),
        change=_option("locked_joint", lambda level: None if level == "none" else level),
        names=("none", *JOINT_NAMES),
    ),
    Disturbance(
        name="unseen",
        title="dance never seen",
        levels=(),
        change=_unseen,
        names=(),
    ),
)

DISTURBANCES = {disturbance.name: disturbance for disturbance in _ALL}
"""All disturbances by name."""
