"""Study `table1`: Table 1 of the paper, with our numbers below the paper's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from mpma_mj.evaluation.statistics import MeanStd
from mpma_mj.experiments.records import Record, converged, matching, mean_std_over_seeds
from mpma_mj.experiments.training import Column, Point, TrainingStudy
from mpma_mj.options import Arms, Models
from mpma_mj.training.config import RunConfig
from mpma_mj.utils.text import markdown_table

__all__ = ["LETTERS", "PAPER", "Table1"]

LETTERS = ("Y", "M", "C", "A")

_UNKNOWN = MeanStd(math.nan, math.nan)


def _paper(
    epochs: tuple[float, float],
    p_e: tuple[float, float],
    ratio: tuple[float, float],
    active: tuple[float, float, float, float],
) -> dict[str, MeanStd]:
    names = ("epochs", "p_e_percent", "feedback_ratio")
    measures = {n: MeanStd(*m) for n, m in zip(names, (epochs, p_e, ratio), strict=True)}
    counts = zip(LETTERS, active, strict=True)
    return measures | {f"active_modules.{letter}": MeanStd(n, math.nan) for letter, n in counts}


PAPER = {
    50: _paper((18, 3.78), (2.76, 0.23), (0.23, 0.02), (1, 1.6, 2.7, 1.05)),
    100: _paper((17, 5.07), (2.73, 0.27), (0.24, 0.09), (1, 1.95, 2.25, 1.05)),
    200: _paper((14, 3.89), (2.76, 0.17), (0.20, 0.02), (1.05, 1.8, 2.25, 1)),
    400: _paper((15, 4.71), (2.79, 0.16), (0.23, 0.06), (1, 2.15, 2.65, 1.05)),
}
"""Table 1 of Tidemann & Öztürk 2008: measures by nodes; p_e in percent, 20 runs a row."""

_WITH_STD = (
    Column("epochs µ/σ", "epochs", 2),
    Column("p_e µ/σ, %", "p_e_percent", 2),
    Column("Σu_fb/Σu µ/σ", "feedback_ratio", 3),
)
_MEANS = (
    *(Column(f"active in {letter}", f"active_modules.{letter}", 2) for letter in LETTERS),
    Column("nmi", "nmi", 2),
    Column("repeatability", "repeatability.responsibility", 3),
    Column("modules used", "modules_used", 2),
)


@dataclass(frozen=True, kw_only=True)
class Table1(TrainingStudy):
    """Reproduce Table 1 of the paper: train the YMCA with networks of several sizes.

    Attributes:
        nodes: Sizes: neurons of each reservoir.
        models: Joint models (ours), or posture models (the paper's).
        rule: Learning rule: weighted (ours), gated (the paper's), or the path of a class.
        arms: Simulated arms, or arms that move ideally.
    """

    name: ClassVar[str] = "table1"
    nodes: tuple[int, ...] = (50, 100, 200, 400)
    models: Models = "joint"
    rule: str = "weighted"
    arms: Arms = "physics"

    def points(self) -> list[Point]:
        """Return a point for each size."""
        base = RunConfig.of(models=self.models, rule=self.rule, arms=self.arms, seed=self.seed)
        return [Point({"nodes": nodes}, base.replace(nodes=nodes)) for nodes in self.nodes]

    def table(self, records: Sequence[Record]) -> str:
        """Return for each size the paper's row, if it has one, and ours."""
        titles = ["nodes", "", *(c.title for c in (*_WITH_STD, *_MEANS)), "all used", "converged"]
        rows = []
        for nodes in self.nodes:
            own = matching(records, {"nodes": nodes})
            if nodes in PAPER:
                rows.append([str(nodes), "paper", *_cells(PAPER[nodes]), "–", "–"])
            ours = {c.measure: mean_std_over_seeds(own, *c.path) for c in (*_WITH_STD, *_MEANS)}
            ended = f"{converged(own)} of {self.runs}"
            rows.append([str(nodes), "ours", *_cells(ours), self._all_used(own), ended])
        title = f"Table 1: ymca, {self.rule} rule, {self.arms} arms"
        return f"{title}\n\n{markdown_table(titles, rows)}"

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.table1_figure import write_figure

        title = f"Table 1: {self.rule} rule, {self.arms} arms, {self.runs} runs a size"
        write_figure(path, records, self.nodes, RunConfig.of().option("modules"), title)

    def _all_used(self, records: Sequence[Record]) -> str:
        """Return the share of the runs in which every module is dominant in some letter."""
        modules = RunConfig.of().option("modules")
        every = [one["modules_used"] == modules for one in records if not one["diverged"]]
        return f"{100 * sum(every) / len(every):.0f} %" if every else "–"


def _cells(measures: dict[str, MeanStd]) -> list[str]:
    found = [(measures.get(column.measure, _UNKNOWN), column) for column in (*_WITH_STD, *_MEANS)]
    texts = [one.text(column.digits, "/") for one, column in found]
    ends = len(_WITH_STD)
    return [*texts[:ends], *(text.split("/")[0] for text in texts[ends:])]
