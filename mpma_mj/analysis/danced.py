"""What a run's modules did in its kept epoch, read from its folder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.load import arm_limits
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import CheckpointError, RunFolderError
from mpma_mj.motions import Motion
from mpma_mj.training.run_folder import RunFolder

__all__ = ["Danced", "read_danced"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Danced:
    """A kept epoch.

    Attributes:
        trace: Its signals, see docs/formats.md.
        motion: The movement that was imitated.
        period: Steps from one repetition to the next.
    """

    trace: dict[str, Array]
    motion: Motion
    period: int


def read_danced(folder: RunFolder) -> Danced:
    """Read the kept epoch of a run.

    Raises:
        RunFolderError: There is no run, or its modules have done nothing yet.
        CheckpointError: The run is damaged, or has no modules.
    """
    config = folder.read_config()
    trace, motion = folder.read_trace(), folder.read_motion()
    options = EnvironmentOptions(motion, repeats=config.repeats)
    demonstration = Demonstration(motion, options, arm_limits(config.arms)[0])
    moments, expected = len(trace["posture"]), demonstration.steps + 1
    if moments != expected:
        raise CheckpointError(
            f"{folder.path / 'trace.npz'}: has {moments} moments, but {motion.name} danced"
            f" {config.repeats} times has {expected}; train anew with --overwrite"
        )
    if not np.any(trace["module_actions"]):
        raise RunFolderError(
            f"{folder.path}: its modules put out nothing in the kept epoch; go on with"
            f" mpma imitate --resume {folder.path}"
        )
    return Danced(trace, motion, demonstration.period)
