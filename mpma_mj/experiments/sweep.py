"""Study of a user's own grid of options, which `mpma sweep` trains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from mpma_mj.experiments.grid import points
from mpma_mj.experiments.records import Record, matching
from mpma_mj.experiments.training import COLUMNS, Point, TrainingStudy
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table, option_name

__all__ = ["Sweep"]

_MEASURES = ("epochs", "p_e_percent", "feedback_ratio", "learned_share", "nmi", "modules_used")
_COLUMNS = [COLUMNS[name] for name in _MEASURES]


@dataclass(frozen=True, kw_only=True)
class Sweep(TrainingStudy):
    """Runs at all points of a grid; see `TrainingStudy`.

    Attributes:
        grid: Options that vary, each "name=value,value,…".
        base: All other options, with the first seed.
    """

    name: ClassVar[str] = "sweep"
    grid: tuple[str, ...] = ()
    base: RunConfig = field(default_factory=RunConfig)

    def points(self) -> list[Point]:
        """Return all points of the grid, with the options that vary as labels."""
        configs = points(self.grid, self.base)
        options = [config.options() for config in configs]
        names = dict.fromkeys(name for own in options for name in own)
        # An option that only some agents have varies together with the agent's name.
        varying = [
            name for name in names if len({str(own[name]) for own in options if name in own}) > 1
        ]
        return [
            Point({name: config.option(name) for name in varying}, config) for config in configs
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return how many runs converged, and means ± standard deviations over seeds."""
        points = self.points()
        titles = [*map(option_name, points[0].labels), "converged", *(c.title for c in _COLUMNS)]
        rows = [
            [*map(_shown, labels.values()), *self.cells(matching(records, labels), _COLUMNS)]
            for labels, _ in points
        ]
        return markdown_table(titles, rows)


def _shown(value: Any) -> str:
    return "–" if value is None else str(value)
