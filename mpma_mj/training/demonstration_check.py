"""What a run has been shown, checked against what it recorded of it."""

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

__all__ = ["demonstrated"]

Array = NDArray[np.float64]

_ALIKE = 1.0  # percent beside what noise makes; another movement is ten times as far away (choice)


def demonstrated(folder: RunFolder) -> tuple[Demonstration, Trace]:
    """Return the demonstration of a run, and the signals of its kept epoch.

    Args:
        folder: Folder of the run.

    Raises:
        RunFolderError: There is no run.
        CheckpointError: The folder is damaged, or its movement is not the one of the trace.
    """
    config, trace, motion = folder.read_config(), folder.read_trace(), folder.read_motion()
    options = dataclasses.replace(config.env, reference_noise=0.0)
    demonstration = Demonstration(motion, options, arm_limits(config.env.arms)[0])
    moments, expected = len(trace.posture), demonstration.steps + 1
    if moments != expected:
        raise CheckpointError(
            f"{folder.path / 'trace.npz'}: has {moments} moments, but {motion.name} danced"
            f" {config.env.repeats} times has {expected}; train anew with --overwrite"
        )
    shown = demonstration.episode(0, 0).reference[:expected]
    off = posture_error_percent(trace.reference, shown)
    heard = np.array_equal(trace.context, demonstration.context)
    if not heard or off > 100.0 * config.env.reference_noise + _ALIKE:
        raise CheckpointError(
            f"{folder.path / 'checkpoint' / 'motion.npz'}: {motion.name} is not the movement of"
            " trace.npz; put the run's own back, or train anew with --overwrite"
        )
    return demonstration, trace
