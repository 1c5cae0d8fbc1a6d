"""Named random streams: one seed for a run, and an independent stream for each purpose.

A stream depends on its name and the seed, not on draws from other streams. Therefore a resumed run
equals an uninterrupted one, and a run in a batch equals the same run alone.
"""

from __future__ import annotations

import zlib

import numpy as np

__all__ = ["stream"]


def stream(seed: int, *path: str | int) -> np.random.Generator:
    """Return the generator of a named stream.

    Args:
        seed: Seed of the run, a non-negative integer.
        *path: Name of the stream, from general to particular, such as `("reservoir_noise", 12)`
            for the noise of episode 12.

    Returns:
        Generator, independent of those of all other names and seeds.
    """
    key = tuple(zlib.crc32(part.encode()) if isinstance(part, str) else part for part in path)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
