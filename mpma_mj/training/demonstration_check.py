"""Demonstration of a run, checked against the trace of its best epoch."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.demonstration import Demonstration
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import CheckpointError
from mpma_mj.metrics import posture_error_percent
from mpma_mj.trace import Trace
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.utils.atomic_files import TRAIN_AGAIN

__all__ = ["demonstrated"]

Array = NDArray[np.float64]

# Largest difference without noise, percent; other motions differ by ten times as much (choice).
_TOLERANCE = 1.0


def demonstrated(folder: RunFolder) -> tuple[Demonstration, Trace]:
    """Return the demonstration of a run, and the trace of its best epoch.

    Args:
        folder: Folder of the run.

    Raises:
        RunFolderError: There is no run.
        CheckpointError: The folder is damaged, or its motion is not the one of the trace.
    """
    config, trace, motion = folder.read_config(), folder.read_trace(), folder.read_motion()
    options = dataclasses.replace(config.env, reference_noise=0.0)
    demonstration = Demonstration(motion, options, arm_limits(config.env)[0])
    moments, expected = len(trace.posture), demonstration.steps + 1
    if moments != expected:
        raise CheckpointError(
            f"{folder.path / 'trace.npz'}: has {moments} moments, but {motion.name} repeated"
            f" {config.env.repeats} times has {expected}",
            remedy=TRAIN_AGAIN,
        )
    reference = demonstration.episode(0, 0).reference[:expected]
    difference = posture_error_percent(trace.reference, reference)
    same_context = np.array_equal(trace.context, demonstration.context)
    if not same_context or difference > 100.0 * config.env.reference_noise + _TOLERANCE:
        raise CheckpointError(
            f"{folder.path / 'checkpoint' / 'motion.npz'}: {motion.name} is not the motion of"
            " trace.npz",
            remedy=f"restore the motion of the run, or {TRAIN_AGAIN}",
        )
    return demonstration, trace
