"""Movements made of another."""

from __future__ import annotations

import dataclasses

import numpy as np

from mpma_mj.motions.motion import Motion

__all__ = ["mirrored", "with_music_of"]

_SIDEWAYS = np.array([1.0, -1.0, 1.0])  # y → -y


def mirrored(motion: Motion) -> Motion:
    """Return a movement with left and right exchanged, to the same music."""
    arms = motion.posture.reshape(-1, 2, 2, 3)  # (T, arm, segment, xyz)
    posture = (arms[:, ::-1] * _SIDEWAYS).reshape(-1, 12)
    return dataclasses.replace(motion, posture=posture)


def with_music_of(motion: Motion, other: Motion) -> Motion:
    """Return a movement danced to another's music.

    Args:
        motion: The movement, T postures.
        other: The movement whose labels are heard, each for its share of the time.
    """
    frames = len(motion)
    heard = np.arange(frames) * len(other) // frames
    return dataclasses.replace(motion, context=other.context[heard], labels=other.labels)
