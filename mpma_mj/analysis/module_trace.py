"""Signals of a run's modules in its best epoch."""

from __future__ import annotations

import numpy as np

from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.errors import CheckpointError, RunFolderError, placeholder
from mpma_mj.trace import Trace
from mpma_mj.training.checkpoints import demonstrated
from mpma_mj.training.run_folder import RunFolder

__all__ = ["read_module_trace"]


def read_module_trace(folder: RunFolder) -> tuple[Demonstration, Trace]:
    """Return the demonstration of a run, and the trace of its best epoch with motor output.

    Raises:
        RunFolderError: There is no run, or its modules have no output yet.
        CheckpointError: The run is damaged, or has no modules.
    """
    demonstration, trace = demonstrated(folder)
    if trace.modules is None:
        raise CheckpointError(f"{folder.path}: its agent has no modules; choose a run of MPMA")
    if not np.any(trace.modules.module_actions):
        raise RunFolderError(
            f"{folder.path}: its modules have no output in the best epoch",
            remedy=f"continue with mpma imitate {placeholder('resume', folder.path)}",
        )
    return demonstration, trace
