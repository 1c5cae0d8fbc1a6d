"""Evaluation conditions of a stress study: the levels of disturbances, each checked beforehand."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from mpma_mj.envs.load import prepare
from mpma_mj.envs.options import FIELDS_OF_PLANTS, EnvironmentOptions
from mpma_mj.errors import BadOptionError, MotionFileError, MotionReachError, MpmaError
from mpma_mj.evaluation.disturbances import DISTURBANCES, Disturbance, Level
from mpma_mj.evaluation.evaluate import EvalCondition
from mpma_mj.motions import Motion
from mpma_mj.motions.read import BUILT_IN
from mpma_mj.training.checkpoints import TrainedAgents
from mpma_mj.training.config import RunConfig

__all__ = ["Trial", "trials"]

_DEFAULTS = {option.name: option.default for option in fields(EnvironmentOptions)}
# What disturbs the arms are forces, and a plant would stand in for the level of a disturbance.
_ARMS = {"arms": "physics"} | {name: _DEFAULTS[name] for name in FIELDS_OF_PLANTS}
_DANCES = 8  # invented ones that are tried (choice)


@dataclass(frozen=True, eq=False)
class Trial:
    """A level of a disturbance.

    Attributes:
        disturbance: Its name.
        level: Its level.
        condition: The condition at that level; None where the arms cannot follow.
    """

    disturbance: str
    level: Level
    condition: EvalCondition | None


def trials(
    names: Sequence[str], levels: Sequence[str], unseen: Sequence[str], own: TrainedAgents
) -> tuple[Trial, ...]:
    """Return all levels of disturbances, each condition looked at whether it can be.

    Args:
        names: Disturbances, in that order.
        levels: Levels of the only disturbance; the usual ones if there are none.
        unseen: Dances that were not seen, in place of the invented ones.
        own: The run, whose movement and settings all have in common.

    Raises:
        MpmaError: There is no such disturbance, a level is outside what it may be, or a dance
            cannot be read, was learned, or is faster than the arms.
    """
    chosen = [_disturbance(name) for name in dict.fromkeys(names)]
    if levels and len(chosen) != 1:
        raise BadOptionError(
            "levels are those of one disturbance", remedy="name it with {disturbances}"
        )
    if unseen and (levels or "unseen" not in names):
        raise BadOptionError(
            "dances are given that are not to be tried",
            remedy="drop {unseen}, or let them be with {disturbances=unseen} and without {levels}",
        )
    config = own.configs[0]
    undisturbed = EvalCondition("undisturbed", own.motion, _ARMS)
    found = []
    for disturbance in chosen:
        given: Sequence[Level] = levels or disturbance.levels
        if disturbance.name == "unseen" and not levels:
            given = unseen or _never_seen(config)
        read = (disturbance.read_level(x) if isinstance(x, str) else x for x in given)
        for level in dict.fromkeys(read):
            found.append(
                Trial(disturbance.name, level, _world(disturbance, level, own, undisturbed))
            )
    return tuple(found)


def _disturbance(name: str) -> Disturbance:
    if name not in DISTURBANCES:
        raise BadOptionError(f"no disturbance '{name}'; expected some of {', '.join(DISTURBANCES)}")
    return DISTURBANCES[name]


def _is_learned(dance: str, config: RunConfig) -> bool:
    """Tell whether a run has learned a dance, however its path is spelled."""
    return Path(dance).resolve() in [Path(motion).resolve() for motion in config.motions]


def _never_seen(config: RunConfig) -> Sequence[str]:
    """Return invented dances that the run has not learned."""
    if "invented" in config.motions:
        raise BadOptionError(
            "the run has learned all invented dances",
            remedy="name others with {unseen}, or choose {disturbances} without unseen",
        )
    dances = (name for name in BUILT_IN if name.startswith("invented-"))
    return list(itertools.islice((d for d in dances if d not in config.motions), _DANCES))


def _changed(
    disturbance: Disturbance, level: Level, motion: Motion
) -> tuple[Motion, dict[str, Any]]:
    """Return the movement and the options of a level."""
    try:
        return disturbance.change(motion, level)
    except BadOptionError as error:
        raise _no_level(disturbance, level, error) from None
    except MotionFileError as error:
        _advise_writing(error)
        raise


def _no_level(disturbance: Disturbance, level: Level, error: BadOptionError) -> BadOptionError:
    # As text, since options of environments and motions are none of this study.
    return BadOptionError(f"{disturbance.name} {level}: {error}")


def _advise_writing(error: MpmaError) -> None:
    """Add what to do with a remedy that is not an option of this study."""
    writes = "mpma motion, with that and {out=FILE.npz}, writes such a dance"
    error.remedy = f"{error.remedy}: {writes}" if error.remedy else writes


def _world(
    disturbance: Disturbance, level: Level, own: TrainedAgents, undisturbed: EvalCondition
) -> EvalCondition | None:
    """Return the condition of a level; None where the arms cannot follow what they have learned."""
    config = own.configs[0]
    if disturbance.name == "unseen" and _is_learned(str(level), config):
        raise BadOptionError(
            f"the run has learned {level}", remedy="name another dance with {unseen}"
        )
    motion, changed = _changed(disturbance, level, own.motion)
    if motion is own.motion and all(value == _DEFAULTS[n] for n, value in changed.items()):
        return undisturbed
    condition = EvalCondition(f"{disturbance.name} {level}", motion, _ARMS | changed)
    try:
        prepare(motion, dataclasses.replace(config.env, **condition.options))
    except BadOptionError as error:
        raise _no_level(disturbance, level, error) from None
    except MotionReachError as error:
        if disturbance.name != "unseen":
            return None
        _advise_writing(error)
        raise
    return condition
