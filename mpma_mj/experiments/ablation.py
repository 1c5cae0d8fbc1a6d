"""Study `ablation`: MPMA with one component changed at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from mpma_mj.evaluation.statistics import interval
from mpma_mj.experiments.records import Record, matching, value
from mpma_mj.experiments.training import COLUMNS, Column, Point, TrainingStudy
from mpma_mj.options import Models
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

__all__ = ["WHOLE", "Ablation"]

WHOLE = "the whole"
"""Row of the agent without a change, with which the others are compared."""

_CHANGES: dict[str, dict[str, Any]] = {
    WHOLE: {},
    "no responsibility predictors": {"responsibility_predictors": False},
    "no forward-model gating": {"forward_gating": False},
    "no context": {"context_signal": "nothing"},
    "constant context": {"context_signal": "constant"},
    "shuffled labels": {"context_signal": "shuffled"},
    "labels twice as fine": {"context_signal": "halves"},
    "no noise in the reservoirs": {"reservoir_noise": 0.0},
    "no noise on the demonstration": {"reference_noise": 0.0},
    "one module": {"modules": 1},
    "10 modules": {"modules": 10},
}
_CHANGES_OF_MODELS: dict[str, dict[str, dict[str, Any]]] = {
    "joint": {"modules' predictions left out": {"temperature": 0.0}},
    "posture": {"forward models receive their own command": {"efference_copy": "module"}},
}

_FEWEST = 5  # runs of a difference that is marked; an interval of fewer is too narrow (choice)

_MEASURES = ("p_e_percent", "epochs", "feedback_ratio", "learned_share", "nmi", "modules_used")
_COLUMNS = [
    COLUMNS[name] for name in (*_MEASURES, "active_modules", "repeatability.responsibility")
]
_TITLES = [column.title for column in _COLUMNS]


@dataclass(frozen=True, kw_only=True)
class Ablation(TrainingStudy):
    """Train MPMA on the YMCA with one component changed at a time.

    Attributes:
        nodes: Neurons of each reservoir.
        models: Joint models (ours), or posture models (the paper's).
        rule: Learning rule: weighted (ours), gated (the paper's), or the path of a class.
    """

    name: ClassVar[str] = "ablation"
    nodes: int = 100
    models: Models = "joint"
    rule: str = "weighted"

    def points(self) -> list[Point]:
        """Return a point for each change; all have the same seeds."""
        base = RunConfig.of(models=self.models, rule=self.rule, nodes=self.nodes, seed=self.seed)
        changes = _CHANGES | _CHANGES_OF_MODELS[self.models]
        return [Point({"change": name}, base.replace(**change)) for name, change in changes.items()]

    def table(self, records: Sequence[Record]) -> str:
        """Return two tables, of means and of differences."""
        own = {name: matching(records, {"change": name}) for name in self._names}
        means = [[name, *self.cells(runs, _COLUMNS)] for name, runs in own.items()]
        differences = [
            [name, *(_difference(own[WHOLE], runs, column) for column in _COLUMNS)]
            for name, runs in own.items()
            if name != WHOLE
        ]
        parts = [
            f"Ablations: ymca, {self.rule} rule, {self.nodes} nodes, physics arms, runs of each:"
            f" {self.runs}. Means ± standard deviations over seeds:",
            markdown_table(("change", "converged", *_TITLES), means),
            "Differences to the whole, seed by seed: means and their 95 % bootstrap intervals, bold"
            f" where these are of {_FEWEST} runs or more and do not contain 0:",
            markdown_table(("change", *_TITLES), differences),
        ]
        if self.runs < _FEWEST:
            parts.append(
                f"Nothing is in bold: intervals of fewer than {_FEWEST} runs are too narrow to"
                " distinguish a change from chance."
            )
        return "\n\n".join(parts)

    @property
    def _names(self) -> list[str]:
        return [point.labels["change"] for point in self.points()]


def _difference(whole: Sequence[Record], own: Sequence[Record], column: Column) -> str:
    """Return by how much a measure changes, over the seeds that have it both times."""
    before, after = ({one["seed"]: value(one, *column.path) for one in r} for r in (whole, own))
    pairs = ((before[seed], after[seed]) for seed in before if seed in after)
    changes = [b - a for a, b in pairs if a is not None and b is not None]
    found = interval(changes)
    text = found.text(column.digits + 1, "+")
    return f"**{text}**" if found.excludes_zero and len(changes) >= _FEWEST else text
