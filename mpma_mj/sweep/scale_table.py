"""Tables of how MPMA scales, and in words where more no longer helps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

from mpma_mj.sweep.asked import by_point, without_seed
from mpma_mj.sweep.folder import Finished
from mpma_mj.sweep.measures import remarks, spread
from mpma_mj.sweep.scale import Growing, Material, Scale, Size
from mpma_mj.sweep.table import markdown_rows

__all__ = ["TOLERANCE", "Results", "as_markdown", "as_rows", "least_enough"]

TOLERANCE = 0.1  # of the best value; what is nearer counts as good (choice)

# Title, name in a summary, digits after the point.
_MEASURES = (
    ("p_e, %", "p_e_percent", 2),
    ("prediction error, %", "prediction_error_percent", 2),
    ("feedback ratio", "feedback_ratio", 3),
    ("epochs", "epochs", 1),
    ("nmi of label and module", "nmi", 2),
    ("modules used", "modules_used", 1),
    ("entropy of λ in the whole (usage), 1 is all modules alike", "entropy.usage", 2),
    ("entropy of λ at a time (sharing), 0 is one module alone", "entropy.sharing", 2),
)


class Results:
    """Finished runs by material and size.

    Attributes:
        scale: What was asked.
    """

    def __init__(self, scale: Scale, runs: Sequence[Finished]) -> None:
        """Sort the runs."""
        self.scale = scale
        self._found: dict[object, list[Finished]] = {}
        for run in runs:
            self._found.setdefault(without_seed(run.config), []).append(run)

    def of(self, material: Material, size: Size) -> list[Finished]:
        """Return the runs of a size on a material."""
        return self._found.get(without_seed(self.scale.point(material, size)), [])

    def mean(self, material: Material, size: Size, measure: str) -> float:
        """Return the mean of a measure over seeds; NaN if there is none."""
        return spread(self.of(material, size), measure).mean

    def growing(self, what: Growing) -> list[Material]:
        """Return the materials of which one is more than the other in this, the least first."""
        return [m for m in self.scale.materials if m.growing == what]


def least_enough(found: Mapping[int, float]) -> int | None:
    """Return the least size from which on all are within `TOLERANCE` of the best, the lowest.

    Args:
        found: Values by size; those that are NaN do not count.

    Returns:
        The size; None if there is no value.
    """
    known = {size: value for size, value in sorted(found.items()) if math.isfinite(value)}
    if not known:
        return None
    most = min(known.values()) * (1.0 + TOLERANCE)
    sizes = list(known)
    worse = [place for place, size in enumerate(sizes) if known[size] > most]
    return sizes[worse[-1] + 1 if worse else 0] if not worse or worse[-1] + 1 < len(sizes) else None
