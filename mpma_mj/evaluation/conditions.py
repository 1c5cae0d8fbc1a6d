"""Evaluation conditions at the levels of disturbances, each checked beforehand."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mpma_mj.envs.load import prepare
from mpma_mj.envs.options import FIELDS_OF_PLANTS, MASS_OPTIONS, EnvironmentOptions
from mpma_mj.errors import BadOptionError, InfeasibleMotionError, MotionFileError, MpmaError
from mpma_mj.evaluation.disturbances import DISTURBANCES, Disturbance, Level
from mpma_mj.evaluation.evaluate import EvalCondition
from mpma_mj.motions import BUILT_IN, Motion
from mpma_mj.options import Arms
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import did_you_mean

__all__ = ["DisturbanceLevel", "disturbance_levels", "shown"]

_DEFAULTS = vars(EnvironmentOptions())
_SYNTHETIC_MOTIONS = 8  # by default (choice)


@dataclass(frozen=True, eq=False)
class DisturbanceLevel:
    """A level of a disturbance.

    Attributes:
        disturbance: Name of the disturbance.
        level: The level.
        condition: The condition at that level; None where it is beyond the arms.
    """

    disturbance: str
    level: Level
    condition: EvalCondition | None


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
            cannot be read, was learned, or is too fast for the arms.
    """
    possible = (d.name for d in DISTURBANCES.values() if arms == "physics" or not d.needs_mass)
    chosen = [_disturbance(name) for name in dict.fromkeys(disturbances or possible)]
    if levels and len(chosen) != 1:
        problem = "levels are given, but they belong to a single disturbance"
        raise BadOptionError(problem, remedy="name it with {disturbances}")
    if motions and (levels or DISTURBANCES["unseen"] not in chosen):
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


def _disturbance(name: str) -> Disturbance:
    if name not in DISTURBANCES:
        raise BadOptionError(
            f"no disturbance '{name}'; expected one or more of {', '.join(DISTURBANCES)}",
            remedy=did_you_mean(name, DISTURBANCES),
        )
    return DISTURBANCES[name]


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
) -> EvalCondition | None:
    """Return the condition of a level; None where the arms cannot follow the learned motion."""
    name = f"{disturbance.name} {shown(level)}"
    unseen = disturbance.name == "unseen"
    learned = [Path(motion).resolve() for motion in config.motions]
    if unseen and Path(str(level)).resolve() in learned:
        raise BadOptionError(f"{level} was learned", remedy="name other {motions}")
    try:
        motion, changed = disturbance.change(undisturbed.motion, level)
        same = all(value == _DEFAULTS[option] for option, value in changed.items())
        if motion is undisturbed.motion and same:
            return undisturbed
        condition = EvalCondition(name, motion, {**undisturbed.options, **changed})
        prepare(motion, dataclasses.replace(config.env, **condition.options))
    except BadOptionError as error:
        # As text, since options of environments and motions are none of an evaluation.
        raise BadOptionError(f"{name}: {error}") from None
    except MotionFileError as error:
        raise _advise_writing(error) from None
    except InfeasibleMotionError as error:
        if not unseen:
            return None
        raise _advise_writing(error) from None
    return condition


def _advise_writing(error: MpmaError) -> MpmaError:
    """Return an error whose remedy, an option of reading, is given to `mpma motion`."""
    writes = "mpma motion, with that and {out=FILE.npz}, writes such a motion"
    error.remedy = f"{error.remedy}: {writes}" if error.remedy else writes
    return error
