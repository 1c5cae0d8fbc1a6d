"""Random streams with names: one seed a run, one independent stream for each purpose.

A stream is found by its name alone, not by how often others were drawn from before. That is
what makes a resumed run equal an uninterrupted one, and one that runs beside others equal
itself alone.
"""

from __future__ import annotations

import zlib

import numpy as np

__all__ = ["stream"]


def stream(seed: int, *path: str | int) -> np.random.Generator:
    """Return the generator that belongs to a name under a seed.

    Args:
        seed: Seed of the run, a non-negative integer; 0 is a seed like any other.
        *path: The stream's name, from general to particular, such as
            `("reservoir_noise", 12)` for the noise of episode 12.

    Returns:
        A generator, independent of those of all other names and seeds.
    """
    key = tuple(zlib.crc32(part.encode()) if isinstance(part, str) else part for part in path)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
