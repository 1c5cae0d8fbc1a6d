"""Variants of motions: mirrored, or with the context of another motion."""

from __future__ import annotations

import dataclasses

import numpy as np

from mpma_mj.motions.motion import Motion

__all__ = ["mirrored", "with_context_of"]

_SIDEWAYS = np.array([1.0, -1.0, 1.0])  # y → -y


def mirrored(motion: Motion) -> Motion:
    """Return a motion with left and right exchanged, and the same context."""
    arms = motion.posture.reshape(-1, 2, 2, 3)  # (T, arm, segment, xyz)
    posture = (arms[:, ::-1] * _SIDEWAYS).reshape(-1, 12)
    return dataclasses.replace(motion, posture=posture)


def with_context_of(motion: Motion, other: Motion) -> Motion:
    """Return a motion with the context of another one.

    Args:
        motion: The motion, T postures.
        other: The motion whose context is stretched or compressed to T postures.
    """
    frames = len(motion)
    index = np.arange(frames) * len(other) // frames
    return dataclasses.replace(motion, context=other.context[index], labels=other.labels)
