"""Built-in motions by name."""

from __future__ import annotations

import functools
from collections.abc import Callable

from mpma_mj.motions.motion import Motion
from mpma_mj.motions.synthetic import SYNTHETIC_MOTIONS, synthetic_motion, ymca

__all__ = ["BUILT_IN"]

BUILT_IN: dict[str, Callable[[float, float], Motion]] = {
    "ymca": ymca,
    "synthetic": synthetic_motion,
    **{
        f"synthetic-{n}": functools.partial(synthetic_motion, number=n)
        for n in range(1, SYNTHETIC_MOTIONS + 1)
    },
}
"""Built-in motions by name, given rate in Hz and tempo."""
