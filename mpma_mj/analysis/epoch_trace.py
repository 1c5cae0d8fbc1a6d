"""What a run's modules did in its kept epoch, read from its folder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import CheckpointError, RunFolderError, placeholder
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import demonstrated
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

    trace: Trace
    motion: Motion
    period: int


def read_danced(folder: RunFolder) -> Danced:
    """Read the kept epoch of a run.

    Raises:
        RunFolderError: There is no run, or its modules have done nothing yet.
        CheckpointError: The run is damaged, or has no modules.
    """
    demonstration, trace = demonstrated(folder)
    if trace.modules is None:
        raise CheckpointError(f"{folder.path}: its agent has no modules; choose a run of MPMA")
    if not np.any(trace.modules.module_actions):
        raise RunFolderError(
            f"{folder.path}: its modules put out nothing in the kept epoch",
            remedy=f"go on with mpma imitate {placeholder('resume', folder.path)}",
        )
    return Danced(trace, demonstration.motion, demonstration.period)
