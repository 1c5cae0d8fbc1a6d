"""Runs that begin with what the agent of an earlier run has learned."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.load import check_same_robot
from mpma_mj.errors import BadOptionError, CheckpointError
from mpma_mj.motions import Motion
from mpma_mj.training.config import Init, RunConfig
from mpma_mj.training.config_json import OutsideConfig
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils import data_files

__all__ = ["begin_from", "initial_state"]

Array = NDArray[np.float64]

# Options of the environment that determine the arms an agent has learned to move.
_BODY = ("arms", "robot")


def begin_from(config: RunConfig, path: str | Path, given: Collection[str]) -> RunConfig:
    """Return the config of a run that begins where the best epoch of an earlier run began.

    Agent, seed, arms and control timestep are those of the earlier run. All options of the agent
    have to agree: readouts mean nothing for other reservoirs, which follow from options and seed.

    Args:
        config: Config of the run.
        path: Folder of the earlier run. It imports no code: classes from outside the package are
            those that `config` names in an option that is given.
        given: Flat names of the options that the user gave. They are compared with those of the
            earlier run; others are taken from it.

    Raises:
        BadOptionError: An option that is given differs.
        RunFolderError: There is no run.
        CheckpointError: The run is damaged, of another version, or has no epoch.
    """
    named = OutsideConfig(options=config.to_json()["agent"]).outside
    trusted = tuple(path for option, path in named.items() if option in given)
    folder = RunFolder(Path(path), trusted)
    saved = folder.read_config()
    _check_same(config, saved, path, given)
    folder.read_best(saved)  # refuses a damaged checkpoint before the motion is read
    taken = _BODY if "control_timestep" in given else (*_BODY, "control_timestep")
    body = {name: getattr(saved.env, name) for name in taken}
    return dataclasses.replace(
        config,
        agent=saved.agent,
        agent_name=saved.agent_name,
        seed=saved.seed,
        env=dataclasses.replace(config.env, **body),
        init=Init(path=str(path), digest=_digest(folder)),
    )


def initial_state(config: RunConfig, motion: Motion) -> dict[str, Array]:
    """Return the state of the agent with which a run begins, arrays by name.

    Args:
        config: Config that `begin_from` returned.
        motion: Motion of the run.

    Raises:
        BadOptionError: The earlier run has another agent, other arms or another control timestep,
            or its motion another number of labels.
        RunFolderError: There is no earlier run.
        CheckpointError: The earlier run is damaged, or its checkpoint has changed.
    """
    assert config.init is not None
    path = config.init.path
    folder = RunFolder(Path(path))
    saved, before = folder.read_config(), folder.read_motion()
    _check_same(config, saved, path, _fixed(config))
    check_same_robot(before.angles_of, motion.angles_of, of_run=True)
    labels, others = len(motion.labels), len(before.labels)
    if labels != others:
        raise BadOptionError(
            option="init",
            value=path,
            expected=f"a run whose motion has {labels} labels, as {motion.name} has; {before.name}"
            f" has {others}",
            remedy="give the motion as many with {segments} or {labels}, or leave {init} out",
        )
    timestep, other = _timestep(config, motion), _timestep(saved, before)
    if not np.isclose(timestep, other):
        raise _differs("control_timestep", timestep, other, path)
    state, _ = folder.read_best(saved)
    if _digest(folder) != config.init.digest:
        raise CheckpointError(
            f"{folder.checkpoint('best')}: has changed since this run began with it",
            remedy="give {init} again",
        )
    return state


def _fixed(config: RunConfig) -> dict[str, Any]:
    """Return what two runs of the same agent have in common, as in JSON by flat names."""
    content = config.to_json()
    own = {"agent" if name == "name" else name: v for name, v in content["agent"].items()}
    return own | {name: content["env"][name] for name in _BODY} | {"seed": config.seed}


def _check_same(
    config: RunConfig, saved: RunConfig, path: str | Path, names: Collection[str]
) -> None:
    """Check that some options of a run are those of the run where it begins."""
    own, others = _fixed(config), _fixed(saved)
    for name, value in own.items():
        if name in names and value != others.get(name):
            raise _differs(name, value, others.get(name), path)


def _differs(option: str, value: Any, other: Any, path: str | Path) -> BadOptionError:
    return BadOptionError(
        option=option,
        value=value,
        expected=f"{other!r}, as in {path}, where the run is to begin",
        remedy=f"leave {{{option}}} out, or {{init}}",
    )


def _timestep(config: RunConfig, motion: Motion) -> float:
    """Return the control timestep of a run, s."""
    return config.env.control_timestep or 1.0 / motion.rate


def _digest(folder: RunFolder) -> str:
    """Return the digest of the content of the checkpoint of the best epoch, in hexadecimal."""
    return data_files.read_digest(folder.checkpoint("best"))
